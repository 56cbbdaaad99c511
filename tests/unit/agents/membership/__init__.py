"""Tests of `agents/membership/`."""
