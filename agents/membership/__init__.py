"""Who belongs to the strand: presence, calls, and the lining up."""
