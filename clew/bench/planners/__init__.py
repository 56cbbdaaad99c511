"""Planners of others, for comparison: each plans on the leader's scans."""
