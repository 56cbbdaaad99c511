"""Liveness of views: who is there, for how long to wait, when to propose. No safety rests on it."""
