"""Tests of `clew/page/`."""
