"""Exhaustive exploration: every schedule with few faults, of the cores that ship, in a small world."""
