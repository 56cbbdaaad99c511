"""Tests of `clew/fleet/`."""
