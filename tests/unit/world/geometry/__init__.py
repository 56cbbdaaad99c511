"""Tests of `world/geometry/`."""
