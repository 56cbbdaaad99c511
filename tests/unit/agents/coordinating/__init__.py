"""Tests of `agents/coordinating/`."""
