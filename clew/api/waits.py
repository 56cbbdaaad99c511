"""Which robot waited for which one, from when to when, and why. Pure.

Rule 1: only waits that entries tell of count. A follower that stands because the robot ahead stands is not
        among them: no entry says since when.
Rule 2: a robot does not wait while it is frozen, or after its death.
"""

from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from protocol.fence import May
from protocol.keys import robot_number
from protocol.timeline import (
    Entry,
    FaultInjected,
    FenceChanged,
    LinkBroken,
    LinkHeard,
    LinkSilent,
    Record,
    RobotDied,
    RobotHeld,
    RobotReleased,
    RobotStarted,
    RobotStranded,
    StrandFormed,
    StrandJoined,
    ViewJoined,
    ViewLeft,
)
from world.record.lines import Line

SILENT, STRETCH, TURN, STRANDED = WHYS = ("silent", "stretch", "turn", "stranded")
ENDS: dict[type[Record], Collection[str]] = {
    LinkHeard: {SILENT},
    LinkBroken: {SILENT},
    RobotReleased: {STRETCH},
    ViewJoined: {SILENT, STRETCH},
    ViewLeft: {TURN},
    StrandJoined: WHYS,
    RobotStarted: WHYS,
    RobotDied: WHYS,
    FaultInjected: WHYS,
}
"""What ends which waits of the robot that it tells of; a fault of a message tells of none."""


@dataclass(frozen=True, slots=True)
class Wait:
    """A robot waits for another one."""

    robot: int
    whom: int | None
    """None: the log does not say."""
    why: str
    from_s: float
    to_s: float | None
    """None: it had not ended."""

    @property
    def wait_s(self) -> float | None:
        """How long it was; None: it had not ended."""
        return None if self.to_s is None else self.to_s - self.from_s


@dataclass(slots=True)
class _Waits:
    """The waits up to now."""

    ended: list[Wait] = field(default_factory=list)
    going_on: dict[tuple[int, str, int | None], float] = field(default_factory=dict)
    _order: tuple[int, ...] = ()
    _bound: dict[int, int] = field(default_factory=dict)
    """The epoch of the view in which a robot stands."""
    _turn: tuple[int, int] = (0, 0)
    """The epoch, and the robot that has the turn; 0: none."""
    _awake_s: dict[int, float] = field(default_factory=dict)

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        t_s, record = entry.t_s, entry.record
        robot = _about(source, record)
        self._end(t_s, robot, ENDS.get(type(record), ()), getattr(record, "neighbour", None))
        match record:
            case LinkSilent(neighbour=whom, silent_s=silent_s):
                self._begin(max(t_s - silent_s, self._awake_s.get(robot, 0.0)), robot, SILENT, whom)
            case RobotHeld():
                behind = self._order[self._order.index(robot) + 1 :] if robot in self._order else ()
                self._begin(t_s, robot, STRETCH, next(iter(behind), None))
            case RobotStranded(by=by):
                self._begin(t_s, robot, STRANDED, by)
            case StrandFormed(order=order):
                self._order = order
            case RobotDied() | FaultInjected(process=str()):
                self._bound.pop(robot, None)
                self._awake_s[robot] = t_s  # at the earliest: a thaw or a start is such a fault, too
            case _:
                self._hear_view(t_s, robot, record)

    def _hear_view(self, t_s: float, robot: int, record: Record) -> None:
        match record:
            case ViewJoined(epoch=epoch):
                self._bound[robot] = epoch
                self._await_turn(t_s, robot)
            case ViewLeft() | StrandJoined() | RobotStarted():
                self._bound.pop(robot, None)
            case FenceChanged(epoch=epoch, may=may, named=named):
                self._turn = (epoch, named if may is May.ONE else 0)
                for each in self._bound:
                    self._end(t_s, each, {TURN})
                    self._await_turn(t_s, each)
            case _:
                pass  # tells of no wait

    def _await_turn(self, t_s: float, robot: int) -> None:
        epoch, named = self._turn
        if named not in {0, robot} and self._bound[robot] == epoch:
            self._begin(t_s, robot, TURN, named)

    def _begin(self, t_s: float, robot: int, why: str, whom: int | None) -> None:
        self.going_on.setdefault((robot, why, whom), t_s)

    def _end(self, t_s: float, robot: int, whys: Collection[str], whom: int | None = None) -> None:
        for key in [each for each in self.going_on if each[0] == robot and each[1] in whys]:
            if whom in {None, key[2]} and (from_s := self.going_on.pop(key)) < t_s:
                self.ended.append(Wait(robot, key[2], key[1], from_s, t_s))


def _about(source: str, record: Record) -> int:
    """The robot of which an entry tells; 0: none."""
    if isinstance(record, RobotDied | RobotStranded):
        return record.robot
    if isinstance(record, FaultInjected):
        return robot_number(record.process or "") or 0
    return robot_number(source) or 0


def waits_of(lines: Iterable[Line]) -> list[Wait]:
    """The waits of a run, by when they began."""
    waits = _Waits()
    for source, entry in sorted(lines, key=lambda line: line[1].t_s):
        waits.hear(source, entry)
    going_on = [Wait(robot, whom, why, from_s, None) for (robot, why, whom), from_s in waits.going_on.items()]
    return sorted([*waits.ended, *going_on], key=lambda wait: (wait.from_s, wait.robot))
