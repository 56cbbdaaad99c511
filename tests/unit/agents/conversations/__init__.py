"""Conversations of real robots with each other and with the register."""
