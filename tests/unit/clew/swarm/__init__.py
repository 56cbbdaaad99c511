"""Tests of `clew/swarm/`."""
