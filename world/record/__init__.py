"""The record of a run: writing the timeline, reading it, and resuming a world from it."""
