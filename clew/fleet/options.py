"""Values of command-line options that several commands share."""

import argparse
import math
from importlib import metadata

from protocol import laws
from protocol.errors import UsageError
from protocol.run_settings import SEED_MAX, SPEED_MAX
from world.scenario.sections import TIME_S_MAX

DEPLOYMENTS = ("random",)  # the values of `--deployment`


def seed_of(text: str) -> int:
    """The seed in a text.

    Raises:
        argparse.ArgumentTypeError: the text is invalid.
    """
    if not (text.isascii() and text.isdecimal() and int(text) <= SEED_MAX):
        raise argparse.ArgumentTypeError(f"must be a whole number from 0 to 2**53 - 1, got {text}")
    return int(text)


def law_of(text: str) -> str:
    """The law's name in a text.

    Raises:
        argparse.ArgumentTypeError: there is no such law.
    """
    try:
        laws.check(text)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from error
    return text


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


def time_of(text: str) -> float:
    """The time limit in a text [s].

    Raises:
        argparse.ArgumentTypeError: the text is invalid.
    """
    try:
        time_s = float(text)
    except ValueError:
        time_s = math.nan
    if not 0.0 < time_s <= TIME_S_MAX:
        raise argparse.ArgumentTypeError(f"must be a number in (0, {TIME_S_MAX:g}], got {text}")
    return time_s


def version() -> str:
    """The version of Clew, for people."""
    try:
        return f"clew {metadata.version('clew')}"
    except metadata.PackageNotFoundError:  # a checkout that was never set up
        return "clew, not installed"
