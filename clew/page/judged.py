"""Checks the verdict beside a log: whether it is valid, and whether it belongs to this log.

Rule 1: an invalid verdict never reaches the page, because the page shows numbers unchecked.
Rule 2: the log's poses, judged as by the monitor, give the verdict's distances within `SAME_M` and the same
        number of steps. An incomplete log may give larger distances and fewer steps.
"""

import math
from collections.abc import Iterator
from typing import Any

import msgspec
from msgspec import Struct

from world.judge.verdict import VERDICT_FILE, Verdict

SAME_M = 5e-5  # half of the last printed digit; twelve runs differed by less than 1e-15


class Measured(Struct, frozen=True, kw_only=True):
    """The values from the log's own entries, if they can be judged; infinity: nothing came near."""

    clearance_m: float = math.inf
    moving_clearance_m: float = math.inf
    separation_m: float = math.inf
    steps: int


def unread(verdict: dict[str, Any]) -> str | None:
    """The reason why this is no valid verdict, in a sentence; None: it is valid."""
    try:
        msgspec.convert(verdict, Verdict)
    except msgspec.ValidationError as error:
        return f"{VERDICT_FILE} cannot be read: {error}"
    return None


def contradictions(measured: Measured, verdict: dict[str, Any], *, whole: bool) -> Iterator[str]:
    """The differences between a verdict and its log, in sentences; `whole`: the log is complete."""
    said = msgspec.convert(verdict, Verdict)
    for name, here_m, there_m in (
        ("clearance", measured.clearance_m, said.clearance_m_min),
        ("clearance of what moves", measured.moving_clearance_m, said.moving_clearance_m_min),
        ("separation", measured.separation_m, said.separation_m_min),
    ):
        if there_m is None or math.isinf(here_m):
            continue
        if here_m < there_m - SAME_M or (whole and here_m > there_m + SAME_M):
            yield (
                f"the log's own poses say a least {name} of {here_m:.4f} m, and {VERDICT_FILE} says "
                f"{there_m:.4f} m: the verdict is not of this log"
            )
    if measured.steps > said.switching_steps or (whole and measured.steps < said.switching_steps):
        yield (
            f"the log's own entries say {measured.steps} switching steps, and {VERDICT_FILE} says "
            f"{said.switching_steps}: the verdict is not of this log"
        )
