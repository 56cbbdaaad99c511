"""Figures of a run and of a campaign, for print, by matplotlib."""
