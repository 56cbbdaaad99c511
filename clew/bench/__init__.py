"""Benchmarks: how long things take, compared with a baseline in the same run."""
