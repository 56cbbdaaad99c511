"""The house: its layout, its rules, and docs that are made from the source."""
