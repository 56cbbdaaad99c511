"""Checks of the repository: its layout, its rules, and docs that are generated from the source."""
