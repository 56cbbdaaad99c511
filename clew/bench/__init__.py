"""Benchmarks: how long things take, beside what else could be had."""
