"""A robot's part in views: its state, its reports, its turn, and when it proposes a view."""
