"""A live fleet: its request, its preparation, its supervision, its live table and its summary."""
