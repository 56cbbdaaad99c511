"""What tests share does what it is asked for."""
