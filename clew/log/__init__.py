"""Timelines: read, followed, checked, compared, replayed."""
