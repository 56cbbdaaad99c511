"""How a process starts, is asked to end, and ends."""
