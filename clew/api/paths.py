"""Paths as a Python user gives them."""

from pathlib import Path

from protocol.errors import UsageError


def path_of(name: str, given: object, what: str) -> Path:
    """The path that was given as `name`, which is to be `what`.

    Raises:
        UsageError: it is no path; or an empty one, which `Path` takes for the present folder.
    """
    if not isinstance(given, str | Path) or given == "":
        raise UsageError(f"{name}: must be {what}, got {given!r}")
    return Path(given)
