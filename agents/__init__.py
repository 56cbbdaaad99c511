"""One robot: what it makes of a scan, where it steps, whom it follows."""
