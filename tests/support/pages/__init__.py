"""Pages and browsers for tests."""
