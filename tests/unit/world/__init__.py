"""Tests of `world/`."""
