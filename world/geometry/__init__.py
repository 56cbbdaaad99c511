"""Shapes, rays and distances, static and moving."""
