"""What robots have told the coordinator of a view, and which robots it has to answer. Pure.

Rule 1: a report of an older life came late and changes nothing. Any other report is answered, also one that
        does not count: the robot goes on reporting, and counts in this view when suspicion lets it.
Rule 2: once the formation is made, no report counts any more. A report of a robot that suspicion leaves out
        does not count for as long as that lasts.
"""

from collections.abc import Iterable, Set
from dataclasses import dataclass, field

from agents.coordinating.turns import Turns
from agents.liveness.presence import GRACE_S
from agents.liveness.suspicion import Suspicion
from protocol.wire.view import Report


@dataclass(slots=True)
class Reported:
    """The reports of one view."""

    suspicion: Suspicion
    robots: int
    """How many robots the mission has."""
    _looked_s: float
    """When lost robots were looked for last; at first: since when there is the view."""
    counted: dict[int, Report] = field(default_factory=dict)
    """The newest of each robot whose reports count."""
    said: dict[int, Report] = field(default_factory=dict)
    """What each robot has said last, whether it counts or not."""
    due: set[int] = field(default_factory=set)
    """Whom to answer."""
    _heard_s: dict[int, float] = field(default_factory=dict)

    def hear(self, robot: int, report: Report, now_s: float, *, closed: bool) -> bool:
        """Take in a report; whether it counts and is new (rules 1 and 2)."""
        known = self.counted.get(robot)
        if known is not None and known.life != report.life and report.turn < known.turn:
            return False
        self.due.add(robot)
        self._heard_s[robot], self.said[robot] = now_s, report
        if closed or robot in self.suspicion.suppressed(now_s):
            return False
        return known is None or known.life != report.life or known.number < report.number

    def count(self, robot: int, report: Report) -> None:
        """From now on this report counts."""
        self.counted[robot] = report

    def drop(self, robot: int) -> None:
        """The reports of a robot count no more."""
        del self.counted[robot]

    def ask(self, robots: Iterable[int]) -> None:
        """There is something new to tell these robots."""
        self.due.update(robots)

    def take_due(self) -> list[int]:
        """Remove and return the robots to answer."""
        due = sorted(self.due)
        self.due.clear()
        return due

    def told(self, robots: Iterable[int]) -> None:
        """These robots have just been told everything."""
        self.due.difference_update(robots)

    def old(self, robots: Iterable[int], turns: Turns) -> set[int]:
        """Those of these robots whose place may be older than their own last turn."""
        had_turn = turns.put_for.keys() & robots
        return {robot for robot in had_turn if self.counted[robot].turn <= turns.put_for[robot]}

    def unheard(self, now_s: float) -> Set[int]:
        """The robots that may report yet."""
        return self.missing(now_s - GRACE_S) - self.suspicion.suppressed(now_s)

    def missing(self, since_s: float) -> set[int]:
        """The robots that do not count, and may have shown a token since then."""
        presence, others = self.suspicion.presence, set(range(1, self.robots + 1)) - self.counted.keys()
        return {each for each in others if not (presence.sees_all and presence.has_gone_by(each, since_s))}

    def lost(self, own: int, now_s: float, *, owing: Set[int], silent_s: float) -> list[int]:
        """The robots that count and are gone, except `own`; at one time they are looked for only once.

        A robot in `owing` that has been silent for `silent_s` is gone, too, even if it shows a token.
        """
        if now_s == self._looked_s or not self.suspicion.judges(now_s):
            return []
        self._looked_s = now_s
        silent = {robot for robot in owing if now_s - self._heard_s[robot] > silent_s}
        gone = {
            robot for robot in self.counted if self.suspicion.has_gone(robot, self._heard_s[robot], now_s)
        }
        return sorted((gone | silent) - {own})
