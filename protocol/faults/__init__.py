"""Fault injection: fault plans, and their effects on messages and processes, live and rehearsed."""
