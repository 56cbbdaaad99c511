"""Random worlds, each decided by its kind, its seed and a few numbers."""
