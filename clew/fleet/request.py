"""A request for a live run, each value checked by itself: the options of `clew run`."""

from dataclasses import dataclass
from pathlib import Path

MIB_BYTES = 1 << 20
KEEP_MIB_MAX = 1 << 20  # a TiB: more than a disk has for each robot


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """A request from the command line, each value checked by itself."""

    scenario: str
    robots: int | None
    seed: int
    law: str | None
    deployment: str | None
    time_s_max: float | None
    speed: float | None
    """Times real time; None: as fast as the robots answer."""
    faults: str | None
    out: Path | None
    as_json: bool
    quiet: bool
    view: bool
    routers: int
    keep: float
    """How many MiB of inputs each process of a robot keeps."""
    held: bool
    """Whether the run goes on only as far as it is asked to; for `max`."""
    connect: str | None
    listen: str | None
