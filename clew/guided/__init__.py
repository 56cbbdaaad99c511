"""Guided search: forks a rehearsal where it reaches something new, and plays several futures."""
