"""Coordinating a view: the draft, the turns, the formation."""
