"""Reads scenarios and scenes into frozen values: deployments, error budget, checks."""
