"""Mutation testing: rules of our source are broken one by one, and a campaign must notice each."""
