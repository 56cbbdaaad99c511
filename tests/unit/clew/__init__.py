"""Tests of `clew/`."""
