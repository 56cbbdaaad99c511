"""Scenes and standpoints for tests."""
