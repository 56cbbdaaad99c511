"""Tests of `world/scenario/`."""
