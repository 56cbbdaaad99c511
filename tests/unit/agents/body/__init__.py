"""Tests of `agents/body/`."""
