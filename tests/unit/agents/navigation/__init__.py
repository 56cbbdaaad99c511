"""Tests of `agents/navigation/`."""
