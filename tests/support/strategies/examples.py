"""How many examples a property is tried with, where that is not the usual number."""

from hypothesis import settings

USUAL = 25
"""What the numbers that tests ask for are measured by."""


def examples(count: int) -> int:
    """So many for each `USUAL` of the profile in use: `tests/conftest.py` has fewer in the short form."""
    return max(count * settings().max_examples // USUAL, 2)
