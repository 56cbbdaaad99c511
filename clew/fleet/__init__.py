"""A live fleet: what it is asked for, how it is prepared, its table while it runs, its summary."""
