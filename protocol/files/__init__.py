"""Files that people write: read into checked types, refused in one line, written again."""
