"""Tests of `world/record/`."""
