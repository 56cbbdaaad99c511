"""Tests of the records of the log."""
