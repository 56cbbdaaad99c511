"""Files of users: read into checked types, refused in one line, and written."""
