"""Tests of `world/judge/truth/`."""
