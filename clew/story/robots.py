"""What each robot does, by what the timeline has said of it so far. Pure.

Rule 1: how a robot goes on from entry to entry stands in the tables of `clew/story/states.py`.
Rule 2: entries of one robot may come after later ones of others; its changes never go back in time.
"""

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field

from clew.story.states import (
    ANEW,
    BEGINS,
    CONDUCT,
    ENDS,
    OF_PROCESS,
    PROCESS,
    TELLING,
    Conduct,
    Derived,
    Event,
    Kept,
    Process,
    State,
    event_of,
)
from protocol.fence import May
from protocol.timeline import Entry, FenceChanged, Record, RobotPlaced, StrandFormed, StrandJoined


@dataclass(slots=True)
class Robot:
    """One robot, as far as the timeline has told of it."""

    number: int
    process: Process = Process.ABSENT
    conduct: Conduct = Conduct.BOUND
    place: int | None = None
    """In the strand; the leader's is 0."""
    epoch: int = 0
    """The newest in which it has had a place."""
    kept: set[tuple[Kept, int]] = field(default_factory=set)
    """What keeps it, and which neighbour is silent; 0: it is no neighbour."""

    @property
    def state(self) -> State:
        """What it does."""
        return self._telling({self.conduct, *(kept for kept, _ in self.kept)})

    @property
    def doing(self) -> State:
        """The same of the robot alone, whatever has stopped its body."""
        return self._telling({self.conduct, *(kept for kept, _ in self.kept if kept is not Kept.STOPPED)})

    def _telling(self, holds: AbstractSet[Conduct | Kept]) -> State:
        if self.process is not Process.RUNS:
            return OF_PROCESS[self.process]
        otherwise = State.LEADING if self.place == 0 else State.FOLLOWING
        return next((state for part, state in TELLING if part in holds), otherwise)

    @property
    def silent(self) -> tuple[int, ...]:
        """The neighbours that it does not hear."""
        return tuple(sorted(neighbour for kept, neighbour in self.kept if kept is Kept.SILENCE))

    def take(self, event: Event, record: Record | None = None) -> None:
        """Something has happened to it, by this record where it has more to say."""
        self.process = PROCESS.get((self.process, event), self.process)
        self.conduct = CONDUCT.get((self.conduct, event), self.conduct)
        neighbour = getattr(record, "neighbour", 0)
        if event in ANEW:
            self.place = None
            self.kept = {each for each in self.kept if each[0] in ANEW[event]}
        if event in BEGINS:
            self.kept.add((BEGINS[event], neighbour))
        elif event in ENDS:
            self.kept.discard((ENDS[event], neighbour))
        match record:
            case StrandJoined(epoch=epoch, rank=rank):
                self.epoch, self.place = epoch, rank
            case RobotPlaced(rank=rank):
                self.place = rank
            case _:
                pass  # says nothing of its place

    def move(self) -> None:
        """Its body has moved: nothing stops it any more."""
        self.kept.discard((Kept.STOPPED, 0))


@dataclass(frozen=True, slots=True)
class Change:
    """A robot is in this state from a time on."""

    t_s: float
    robot: int
    state: State
    doing: State
    """`state` but for a dead-man stop."""


@dataclass(slots=True)
class Robots:
    """All robots, and how their states have changed."""

    each: dict[int, Robot] = field(default_factory=dict)
    changes: list[Change] = field(default_factory=list)
    """In the order in which they were heard of."""
    _newest: dict[int, Change] = field(default_factory=dict)
    _turn: int = 0
    """The robot that has the turn; 0: none."""
    _backs_up: set[int] = field(default_factory=set)
    """The epochs in which the strand goes back along its path."""

    def of(self, robot: int) -> Robot:
        """A robot; of one that nothing has been heard of nothing is known."""
        found = self.each.get(robot)
        if found is None:
            found = self.each[robot] = Robot(robot)
        return found

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        told = event_of(source, entry.record)
        if told is not None:
            self._take(entry.t_s, told[0], told[1], entry.record)
        for number, derived in list(self._derived(entry.record, told)):
            self._take(entry.t_s, number, derived)

    def _take(self, t_s: float, number: int, event: Event, record: Record | None = None) -> None:
        robot = self.of(number)
        robot.take(event, record)
        self._note(t_s, robot)

    def _derived(self, record: Record, told: tuple[int, Event] | None) -> Iterator[tuple[int, Derived]]:
        """What an entry about the whole strand means for single robots."""
        match record:
            case FenceChanged(may=may, named=named):
                before, self._turn = self._turn, named if may is May.ONE else 0
                if before not in {0, self._turn}:
                    yield before, Derived.TURN_ENDED
                if self._turn:
                    yield self._turn, Derived.TURN_GIVEN
            case StrandFormed(epoch=epoch, order=order, back_by_m=back_by_m) if back_by_m > 0.0:
                self._backs_up.add(epoch)
                yield from ((each, Derived.BACKS_UP) for each in order if self.of(each).epoch == epoch)
            case StrandJoined(epoch=epoch) if told is not None and epoch in self._backs_up:
                yield told[0], Derived.BACKS_UP
            case _:
                pass  # tells of one robot only

    def move(self, t_s: float, robot: int) -> None:
        """The body of a robot has moved."""
        moved = self.of(robot)
        if moved.kept:
            moved.move()
            self._note(t_s, moved)

    def _note(self, t_s: float, robot: Robot) -> None:
        """Rule 2."""
        before, now = self._newest.get(robot.number), (robot.state, robot.doing)
        if before is None or (before.state, before.doing) != now:
            at_s = t_s if before is None else max(t_s, before.t_s)
            change = self._newest[robot.number] = Change(at_s, robot.number, *now)
            self.changes.append(change)
