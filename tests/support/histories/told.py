"""The elements of histories: each step is a time, an event, and the commands that it must cause."""

from dataclasses import dataclass
from signal import SIGCONT, SIGKILL, SIGTERM

from clew.fleet.supervision.events import (
    HOST,
    TABLE,
    WORLD,
    Activate,
    Begun,
    Command,
    Ended,
    Event,
    Exit,
    Gone,
    Publish,
    Ready,
    Say,
    Signal,
    Start,
)
from clew.fleet.supervision.limits import Plan
from clew.fleet.supervisor import Supervisor
from protocol.process.ending import FAIL

R1, R2 = "router-1", "router-2"

Step = tuple[float, Event, list[Command]]


@dataclass(frozen=True, slots=True)
class History:
    """The events of a run with these parts, and the commands of its supervisor."""

    plan: Plan
    steps: tuple[Step, ...]


def stop(part: str) -> list[Command]:
    return [Signal(part, SIGTERM, group=True), Signal(part, SIGCONT, group=True)]


def kill(part: str) -> Signal:
    return Signal(part, SIGKILL, group=True)


def again(words: str) -> Say:
    return Say(f"{words}; it is started again")


def gone(at_s: float, part: str, status: int = 0) -> tuple[Step, ...]:
    """A part that ends on request and is not the last one."""
    return (at_s, Ended(part, status), []), (at_s, Gone(part), [])


def rest_ends(at_s: float, code: int) -> tuple[Step, ...]:
    """The world's group is gone; router and host end on request."""
    return (
        (at_s, Gone(WORLD), [*stop(R1), *stop(HOST)]),
        *gone(at_s + 0.1, HOST, 143),
        (at_s + 0.1, Ended(R1, 143), []),
        (at_s + 0.1, Gone(R1), [Exit(code)]),
    )


ONE = Plan()
FLEET: list[Command] = [Start(WORLD), Start(HOST), Publish()]
UP: tuple[Step, ...] = (
    (0.0, Begun(), [Activate(R1), Start(R1)]),
    (0.3, Ready(R1, "ready unixsock-stream//tmp/router.sock"), FLEET),
)
UP_WITH_TWO: tuple[Step, ...] = (
    (0.0, Begun(), [Activate(R1), Start(R1)]),
    (0.3, Ready(R1), [Start(R2)]),
    (0.6, Ready(R2), FLEET),
)
UP_WITH_TABLE: tuple[Step, ...] = (
    (0.0, Begun(), [Activate(R1), Start(R1)]),
    (0.3, Ready(R1), [Start(WORLD), Start(TABLE), Start(HOST), Publish()]),
)
WORLD_IS_ASKED: list[Command] = [Signal(WORLD, SIGTERM), Signal(WORLD, SIGCONT)]
WORLD_IS_FAILED: list[Command] = [Signal(WORLD, FAIL), Signal(WORLD, SIGCONT)]
REST_IS_ASKED: list[Command] = [*stop(R1), *stop(HOST)]
PAGE = "http://127.0.0.1:4321/"


KILLED_WORLD = again("the world was killed by SIGKILL")
KILLED_ROUTER = again("router 1 was killed by SIGKILL")


def replay(history: History) -> Supervisor:
    """The supervisor at the end of a history; fails if its commands differ."""
    supervised = Supervisor(history.plan)
    for at_s, event, commands in history.steps:
        assert supervised.handle(event, at_s) == commands, (at_s, event)
    return supervised
