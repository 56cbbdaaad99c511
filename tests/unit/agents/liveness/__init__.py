"""Tests of `agents/liveness/`."""
