"""Test stages: one part of a robot or of the world, with the messages of its peers."""
