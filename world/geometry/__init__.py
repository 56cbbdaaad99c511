"""Shapes, rays and distances, standing and moving."""
