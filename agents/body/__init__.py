"""A robot's use of its body: drive orders, scans, and scans while driving."""
