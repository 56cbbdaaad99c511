"""Figures of a run and of a campaign, for print. Only `verb` and `extra` do without matplotlib."""
