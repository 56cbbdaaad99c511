"""Coverage counters: which rare situations a timeline contains."""
