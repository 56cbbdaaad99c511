"""Tests of `clew/export/`."""
