"""Reads, follows, checks, compares and replays timelines."""
