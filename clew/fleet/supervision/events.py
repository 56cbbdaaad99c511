"""What a supervisor is told and what it commands: two closed unions, and the names of a fleet's parts."""

import contextlib
import math
from dataclasses import dataclass
from signal import Signals

from protocol.exit_codes import ExitCode
from protocol.faults.process_faults import ProcessAction

WORLD, HOST, VIEWER, TABLE = "world", "host", "viewer", "table"
ROUTER = "router"
"""Of the routers, the one that carries the fleet."""


def router_name(number: int) -> str:
    """The part that is router 1 or 2."""
    return f"{ROUTER}-{number}"


@dataclass(frozen=True, slots=True)
class Begun:
    """The run may begin."""


@dataclass(frozen=True, slots=True)
class Ready:
    """A part has said its first line on stdout: a router listens, a viewer serves its page there."""

    part: str
    said: str = ""


@dataclass(frozen=True, slots=True)
class Ended:
    """A part's process has ended; others of its group may still be there."""

    part: str
    status: int
    """The exit code, or minus the number of the signal that has killed it."""


@dataclass(frozen=True, slots=True)
class Gone:
    """No process of a part's group is left."""

    part: str


@dataclass(frozen=True, slots=True)
class Judged:
    """The run has its verdict: no data can be lost any more."""

    exit_code: int
    """What the verdict says, by this name, that the run exits with."""


@dataclass(frozen=True, slots=True)
class Asked:
    """Somebody asks for the end of the run, by SIGINT, SIGTERM or SIGHUP."""

    code: ExitCode
    """What the run is to exit with."""


@dataclass(frozen=True, slots=True)
class FaultAsked:
    """A process fault is asked for."""

    action: ProcessAction
    process: str
    wall_s: float | None = None
    """After so long it is undone; None: at once for what was killed, never for what was frozen."""


@dataclass(frozen=True, slots=True)
class Tick:
    """Time has passed."""


Event = Begun | Ready | Ended | Gone | Judged | Asked | FaultAsked | Tick


@dataclass(frozen=True, slots=True)
class Start:
    """Start a part in a process group of its own."""

    part: str
    resume: bool = False
    """A world goes on from the timeline of the one before."""


@dataclass(frozen=True, slots=True)
class Signal:
    """Send a signal to a part's process, or to all processes of its group."""

    part: str
    signal: Signals
    group: bool = False


@dataclass(frozen=True, slots=True)
class Say:
    """Tell the user."""

    text: str


@dataclass(frozen=True, slots=True)
class Activate:
    """This router carries the fleet from now on."""

    part: str


@dataclass(frozen=True, slots=True)
class Publish:
    """The run has begun: `runs/latest` is its folder."""


@dataclass(frozen=True, slots=True)
class MendTerminal:
    """The table has died in the middle of a picture: show the cursor and begin a line."""


@dataclass(frozen=True, slots=True)
class Exit:
    """Nothing is left to supervise."""

    code: int


Command = Start | Signal | Say | Activate | Publish | MendTerminal | Exit


def fault_in(line: str) -> FaultAsked | None:
    """The process fault that a line asks for, as `kill world` or `kill router 2.5`; None: none of ours."""
    with contextlib.suppress(ValueError):
        match line.split():
            case [action, process]:
                return FaultAsked(ProcessAction(action), process)
            case [action, process, wall] if math.isfinite(wall_s := float(wall)) and wall_s >= 0.0:
                return FaultAsked(ProcessAction(action), process, wall_s)
    return None
