"""Timelines for other tools: MCAP, CSV, Parquet, Rerun. docs/export.md says which tool opens what."""
