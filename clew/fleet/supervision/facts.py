"""What a supervisor knows of a fleet's parts, and what an event means by that. It decides nothing.

Rule 1: every event changes the facts before anything is decided by it.
Rule 2: only a router's first `Ready` counts as listening; nobody waits for one that is started again.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum, auto
from signal import Signals
from typing import assert_never

from clew.fleet.supervision.events import (
    HOST,
    ROUTER,
    TABLE,
    VIEWER,
    WORLD,
    Asked,
    Begun,
    Ended,
    Event,
    FaultAsked,
    Gone,
    Judged,
    Ready,
    Tick,
    router_name,
)
from clew.fleet.supervision.limits import Limits
from clew.fleet.supervision.rules import What
from protocol.exit_codes import ExitCode


@dataclass(frozen=True, slots=True)
class Happening:
    """What an event means, and what else of it an action needs."""

    what: What
    part: str = ""
    status: int = 0
    """How it has ended; how we are to."""
    said: str = ""
    fault: FaultAsked | None = None


class Life(Enum):
    """What there is of a part."""

    ABSENT = auto()
    """No process: it was never started, or all of its group have ended."""
    RUNNING = auto()
    ENDED = auto()
    """Its own process has ended; others of its group, as a host's robots, may not have."""


class Facts:
    """What is known of one run."""

    def __init__(self, limits: Limits) -> None:
        self.listening: set[str] = set()
        """Routers that have ever listened."""
        self.page_is_up = False
        self.verdict_code: int | None = None
        """What the verdict says that the run exits with; None: it is not written."""
        self.active = 1
        """The router that carries the fleet."""
        self._limits = limits
        self._lives: dict[str, Life] = {}
        self._losses: Counter[str] = Counter()
        self._timers: list[tuple[float, What, str]] = []
        self._frozen: set[str] = set()

    @property
    def judged(self) -> bool:
        """Whether the verdict is written."""
        return self.verdict_code is not None

    def is_running(self, part: str) -> bool:
        """Whether its process lives."""
        return self._lives.get(part) is Life.RUNNING

    def is_there(self, part: str) -> bool:
        """Whether any process of its group may live."""
        return self._lives.get(part, Life.ABSENT) is not Life.ABSENT

    def present(self) -> list[str]:
        """The parts of which any process may live, in the order in which they were first started."""
        return [part for part in self._lives if self.is_there(part)]

    def started(self, part: str) -> None:
        """A part runs, for the first time or again."""
        self._lives[part] = Life.RUNNING

    def activate(self, router: int) -> None:
        """Another router carries the fleet: all clients change over when theirs has died."""
        self.active = router

    def set_timer(self, what: What, part: str, at_s: float) -> None:
        """This is due for a part at that time."""
        self._timers.append((at_s, what, part))

    def froze(self, part: str) -> None:
        """A process fault has frozen it."""
        self._frozen.add(part)

    def thawed(self, part: str) -> None:
        """It is frozen no more, and need not be thawed."""
        self._frozen.discard(part)
        self._timers = [timer for timer in self._timers if timer[1:] != (What.THAW_DUE, part)]

    def frozen(self) -> list[str]:
        """The parts that a process fault has frozen."""
        return sorted(self._frozen)

    def next_timer_s(self) -> float | None:
        """When the next of them is due."""
        return min((timer[0] for timer in self._timers), default=None)

    def take(self, event: Event, now_s: float) -> Iterator[Happening]:
        """Take an event in; what it means, if there is a rule about that."""
        match event:
            case Begun():
                yield Happening(What.BEGUN)
            case Ready(part, said):
                yield from self._ready(part, said)
            case Ended(part, status):
                yield from self._ended(part, status)
            case Gone(part):
                self._gone(part)
            case Judged(exit_code):
                self.verdict_code = exit_code
            case Asked(code):
                yield Happening(What.ASKED, status=code)
            case FaultAsked():
                yield from self._fault(event)
            case Tick():
                yield from self._due(now_s)
            case _:
                assert_never(event)

    def _ready(self, part: str, said: str) -> Iterator[Happening]:
        if part == VIEWER:
            self.page_is_up = True
            yield Happening(What.PAGE_IS_UP, said=said)
        elif part not in self.listening:
            self.listening.add(part)
            yield Happening(What.ROUTER_LISTENS)

    def _ended(self, part: str, status: int) -> Iterator[Happening]:
        self._lives[part] = Life.ENDED
        self.thawed(part)
        if part == WORLD:
            yield Happening(self._of_world(status), part, status)
        elif part == VIEWER or (part == TABLE and status != 0):
            yield Happening(What.READER_ENDED, part, status)
        elif part == HOST and status != 0:
            yield Happening(What.HOST_FAILED, part, status)
        elif part in (HOST, TABLE):
            pass  # their work is done
        else:
            yield Happening(self._of_router(part, status), part, status)

    def _gone(self, part: str) -> None:
        if self._lives[part] is Life.ENDED:  # one that was started again has a new group
            self._lives[part] = Life.ABSENT

    def _of_world(self, status: int) -> What:
        if status >= 0 or self.judged:
            return What.WORLD_ENDED
        self._losses[WORLD] += 1
        return (
            What.WORLD_KILLED if self._losses[WORLD] <= self._limits.world_restarts_max else What.WORLD_ENDED
        )

    def _of_router(self, part: str, status: int) -> What:
        if part not in self.listening:
            return What.ROUTER_REFUSED if status == ExitCode.USAGE else What.ROUTER_FAILED
        self._losses[ROUTER] += 1
        spent = self._losses[ROUTER] > self._limits.router_restarts_max
        return What.ROUTER_SPENT if spent else What.ROUTER_ENDED

    def _fault(self, asked: FaultAsked) -> Iterator[Happening]:
        part = router_name(self.active) if asked.process == ROUTER else asked.process
        if self.is_running(part):
            yield Happening(What.FAULT, part, fault=asked)

    def _due(self, now_s: float) -> Iterator[Happening]:
        while (at_s := self.next_timer_s()) is not None and at_s <= now_s:
            first = min(self._timers, key=lambda timer: timer[0])
            self._timers.remove(first)
            yield Happening(*first[1:])


def name_of(part: str) -> str:
    """What users call a part: `router 1`, `the world`."""
    return part.replace("-", " ") if part.startswith(f"{ROUTER}-") else f"the {part}"


def end_of(happening: Happening) -> str:
    """How a part has ended, as the user is told: `router 1 was killed by SIGKILL`."""
    name = name_of(happening.part)
    if happening.status >= 0:
        return f"{name} ended with exit code {happening.status}"
    return f"{name} was killed by {_signal_name(-happening.status)}"


def _signal_name(number: int) -> str:
    try:
        return Signals(number).name
    except ValueError:  # one of the real-time signals
        return f"signal {number}"
