"""Tests of `clew/story/`."""
