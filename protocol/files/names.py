"""Suggestions for mistyped words."""

from collections.abc import Iterable
from difflib import get_close_matches

NEAR = 0.65  # of 1: `parqet` is near `parquet` (0.92), and `extra` is not near `track` (0.6)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The suggestion to append to the refusal of a word; empty if no known word is similar."""
    near = get_close_matches(word, list(known), n=1, cutoff=NEAR)
    return f"; did you mean {near[0]!r}?" if near else ""
