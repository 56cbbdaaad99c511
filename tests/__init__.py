"""One file per module, flat; and the real processes."""
