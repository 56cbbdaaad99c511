"""One moment of a fleet, as a value: numbers of `clew.explore.store` and what is under way between them."""

from typing import NamedTuple

WORLD = 0  # as sender and receiver; robots count from 1


class Letter(NamedTuple):
    """A message or a token event on its way to one receiver."""

    sender: int
    receiver: int
    number: int
    """Grows from one message of a process to the next."""
    thing: int
    """The number of its content."""
    is_fault_prone: bool = True
    """Whether faults may strike it: not so for token events and for the start of a process."""


class Process(NamedTuple):
    """One life of one robot."""

    core: int
    life: int
    began: int
    """The tick at which it was started."""
    now_s: float = 0.0
    """The time that it knows."""
    told: int = -1
    """The number of the newest fence that its odometry has told; -1: none."""
    told_n: int = -1
    """The number of that odometry."""
    seen: int = -1
    """The number of the newest scan that it has heard; -1: none."""
    numbered: int = 0
    """The number of its next message, at the least; see rule 4 of `clew.explore.fleet`."""


class Moment(NamedTuple):
    """All that decides what a fleet can do from now on."""

    ticks: int
    handled: int
    """How many letters and faults this tick has had."""
    world: int
    fence: int
    """The number of the fence in force."""
    robots: tuple[Process | None, ...]
    """None: the process is down."""
    lives: tuple[int, ...]
    """How often each robot has been started."""
    cut: tuple[int, ...]
    """Until which tick each robot is cut off from all others and the world."""
    now: tuple[Letter, ...]
    """What arrives now, in this order."""
    later: tuple[tuple[int, Letter], ...]
    """What arrives at a later tick, in the order of arrival."""
    formed: int = -1
    """The number of the formation of the epoch in force, as its coordinator has noted it; -1: none yet."""
