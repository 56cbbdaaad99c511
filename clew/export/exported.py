"""The result of an export."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Exported:
    """A log that has been exported for another tool."""

    entries: int
    """The number of entries written, without the header."""
    flaws: tuple[str, ...]
    """Defects of the log, and things that the export lacks."""
