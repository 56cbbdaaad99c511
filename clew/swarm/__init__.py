"""Worlds and faults that a seed draws."""
