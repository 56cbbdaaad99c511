"""Tests of `clew/coverage/`."""
