"""Figures of a run and of a campaign, for print. Only `verb` does without matplotlib."""
