"""The invariants of every run and their names for people; docs/verdict.md says what each asks for."""

from collections.abc import Mapping

NAMES = {
    "S1": "clearance",
    "S2": "separation",
    "S3": "orders",
    "S4": "promises",
    "F1": "obedience",
    "F2": "in force",
    "F3": "one mover",
    "F4": "one formation",
    "F5": "authority",
    "F6": "sight",
    "P1": "one leader",
    "P2": "epochs",
    "P3": "no ring",
    "P4": "nothing stale",
    "P5": "queues",
    "P6": "no failed core",
    "P7": "one voice",
    "A1": "goal",
    "A2": "arrival",
}
"""In the order of the verdict."""

INVARIANTS = tuple(NAMES)


def named(invariant: str) -> str:
    """The code and the name; a log of another version may have a code that has no name here."""
    return f"{invariant} ({NAMES[invariant]})" if invariant in NAMES else invariant


def counted(violations: Mapping[str, int]) -> str:
    """Which invariants were broken, and how often."""
    return ", ".join(f"{named(each)} {count}" for each, count in violations.items() if count)


def compared(measured_m: float | None, required_m: float | None, between: str) -> str:
    """Both lengths of a broken promise, with the digits that tell them apart; empty if none do."""
    if measured_m is None or required_m is None:
        return ""
    for digits in (4, 6, 9):
        if round(measured_m, digits) != round(required_m, digits):
            return f"{measured_m:.{digits}f} m{between}{required_m:.{digits}f} m"
    return ""
