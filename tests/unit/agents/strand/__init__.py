"""Tests of `agents/strand/`."""
