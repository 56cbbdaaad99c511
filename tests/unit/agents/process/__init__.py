"""Tests of `agents/process/`."""
