"""Tests of `clew/verbs/`."""
