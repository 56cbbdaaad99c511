"""One robot's body: its drive, its sensor, and looking while it drives."""
