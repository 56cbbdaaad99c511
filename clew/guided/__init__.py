"""Guided against uniform search: how soon each finds bugs that are planted on purpose."""
