"""`clew view`: serves the page of a run on loopback, live while the run goes on."""
