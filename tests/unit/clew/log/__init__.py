"""Tests of `clew/log/`."""
