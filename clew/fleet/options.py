"""Values of command-line options that several commands share."""

import math
from importlib import metadata

from protocol.errors import UsageError
from protocol.files.refusals import short
from protocol.run_settings import SPEED_MAX

DEPLOYMENTS = ("random",)  # the values of `--deployment`


def speed_of(text: str) -> float | None:
    """The speed in a text; None for `max`.

    Raises:
        UsageError: the text is invalid.
    """
    try:
        speed = None if text == "max" else float(text)
    except ValueError:
        speed = math.nan
    if speed is not None and not 0.0 < speed <= SPEED_MAX:
        raise UsageError(f"must be max or a number in (0, 1000], got {short(text)}")
    return speed


def version() -> str:
    """The version of Clew, for people."""
    try:
        return f"clew {metadata.version('clew')}"
    except metadata.PackageNotFoundError:  # a checkout that was never set up
        return "clew, not installed"
