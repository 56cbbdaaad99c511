"""Tests of `clew/bench/`."""
