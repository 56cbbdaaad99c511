"""Tests of `clew/figures/`."""
