"""Values of command-line options that several commands share."""

import argparse
import math
from importlib import metadata

from protocol.run_settings import SEED_MAX, SPEED_MAX

DEPLOYMENTS = ("random",)  # the values of `--deployment`


def seed_of(text: str) -> int:
    """The seed in a text.

    Raises:
        argparse.ArgumentTypeError: the text is invalid.
    """
    if not (text.isascii() and text.isdecimal() and int(text) <= SEED_MAX):
        raise argparse.ArgumentTypeError(f"must be a whole number from 0 to 2**53 - 1, got {text}")
    return int(text)


def speed_of(text: str) -> float | None:
    """The speed in a text; None for `max`.

    Raises:
        argparse.ArgumentTypeError: the text is invalid.
    """
    try:
        speed = None if text == "max" else float(text)
    except ValueError:
        speed = math.nan
    if speed is not None and not 0.0 < speed <= SPEED_MAX:
        raise argparse.ArgumentTypeError(f"must be max or a number in (0, 1000], got {text}")
    return speed


def version() -> str:
    """The version of Clew, for people."""
    try:
        return f"clew {metadata.version('clew')}"
    except metadata.PackageNotFoundError:  # a checkout that was never set up
        return "clew, not installed"
