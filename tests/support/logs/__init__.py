"""Logs for tests."""
