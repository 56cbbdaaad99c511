"""Tests of `clew/api/`."""
