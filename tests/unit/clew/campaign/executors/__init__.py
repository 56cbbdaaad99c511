"""Tests of `clew/campaign/`."""
