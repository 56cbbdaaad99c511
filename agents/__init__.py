"""One robot: its core (navigation, strand, membership), its body, and its process."""
