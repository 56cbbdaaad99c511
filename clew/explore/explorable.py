"""What can be explored: a system with one usual next step, and all the faults that may strike instead."""

from collections.abc import Hashable, Iterable, Iterator
from typing import NamedTuple, Protocol, TypeVar

State = TypeVar("State", bound=Hashable)
Rank = tuple[int, ...]


class Fault(NamedTuple):
    """What strikes; what it means is up to the system."""

    kind: str
    robot: int = 0
    ticks: int = 0

    def __str__(self) -> str:
        who = f" r{self.robot}" if self.robot else ""
        return f"{self.kind}{who} {self.ticks}" if self.ticks else f"{self.kind}{who}"


class Explorable(Protocol[State]):
    """A system whose states are values. The same state always goes on in the same way.

    Rule 1: every step, usual or by a fault, leads to a state of a higher rank. So a schedule never returns
            to a state, and a state is complete when all states of lower ranks have been expanded.
    Rule 2: the faults of a state are pairwise different, and none of them is the usual step.
    Rule 3: a step that breaks a promise raises `Breach`.
    """

    def start(self) -> State:
        """The first state."""
        ...

    def rank(self, state: State) -> Rank:
        """Its place in time."""
        ...

    def follow(self, state: State) -> State | None:
        """The state after the usual next step; None where the system ends."""
        ...

    def hurry(self, state: State) -> State | None:
        """The state after one or more usual steps, where only such are left; None where the system ends."""
        ...

    def is_open(self, state: State) -> bool:
        """Whether faults may strike in this state or a later one; once not, never again."""
        ...

    def faults(self, state: State) -> Iterator[Fault]:
        """The faults that may strike now instead of the usual step, in a state that is open."""
        ...

    def strike(self, state: State, fault: Fault) -> State:
        """The state after a fault."""
        ...

    def keep_only(self, states: Iterable[State]) -> None:
        """Only these states, the first one and what follows from them will be asked for."""
        ...

    def say(self, state: State) -> str:
        """The usual next step, for people."""
        ...


class Breach(Exception):  # noqa: N818 - what an exploration looks for, not an error of ours
    """A promise is broken."""

    def __init__(self, promise: str, why: str) -> None:
        super().__init__(f"{promise}: {why}")
        self.promise, self.why = promise, why
