"""The cores of a whole fleet in one process, in virtual time."""
