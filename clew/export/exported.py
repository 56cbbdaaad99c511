"""What an export says of itself."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Exported:
    """A log as another tool may have it now."""

    entries: int
    """How many were written, without the header."""
    flaws: tuple[str, ...]
    """What is wrong with the log, or with what became of it."""
