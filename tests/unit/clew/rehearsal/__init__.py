"""Tests of `clew/rehearsal/`."""
