"""Histories of supervised runs: each event with its time, and the supervisor's commands."""
