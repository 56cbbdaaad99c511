"""Tests of `protocol/faults/`."""
