"""Tests of `clew/fields/`."""
