"""Tests of `clew/judge/`."""
