"""Timelines for other tools: MCAP, CSV and Parquet. docs/export.md says which tool opens what."""
