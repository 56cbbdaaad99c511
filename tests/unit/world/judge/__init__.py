"""Tests of `world/judge/`."""
