"""Random worlds, each determined by its kind, its seed and a few numbers."""
