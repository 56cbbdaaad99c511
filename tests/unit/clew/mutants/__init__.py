"""Tests of `clew/mutants/`."""
