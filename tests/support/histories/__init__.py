"""Histories of supervised runs: what happened when, and what the supervisor commanded."""
