"""Tests of `world/bodies/`."""
