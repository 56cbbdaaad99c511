"""What robots have told the coordinator of a view, and which are there. Pure.

Rule 1: a report of an older life came late and changes nothing. Any other report is answered, also one that
        does not count: the robot goes on reporting, and counts in this view when suspicion lets it.
Rule 2: once the formation is made, no report counts any more. A report of a robot that suspicion leaves out
        does not count for as long as that lasts.
"""

from collections.abc import Collection, Iterable, Mapping, Set
from dataclasses import dataclass, field

from agents.coordinating.turns import Turns
from agents.liveness.presence import GRACE_S
from agents.liveness.suspicion import Suspicion
from protocol.wire.view import Report

UNREPORTED = "it has not reported"
TOO_SILENT = "it was silent, or kept the others waiting, too often lately"


@dataclass(slots=True)
class Reported:
    """The reports of one view."""

    suspicion: Suspicion
    robots: int
    """How many robots the mission has."""
    counted: Mapping[int, Report]
    """The newest of each robot whose reports count."""
    _looked_s: float
    """When lost robots were looked for last; at first: since when there is the view."""
    said: dict[int, Report] = field(default_factory=dict)
    """What each robot has said last, whether it counts or not."""
    _heard_s: dict[int, float] = field(default_factory=dict)

    def is_late(self, robot: int, report: Report) -> bool:
        """Whether a report is of an older life than the one that counts (rule 1)."""
        known = self.counted.get(robot)
        return known is not None and known.life != report.life and report.turn < known.turn

    def hear(self, robot: int, report: Report, now_s: float) -> bool:
        """Take in a report that is not late; whether it is new, and suspicion lets the robot count."""
        self._heard_s[robot], self.said[robot] = now_s, report
        known = self.counted.get(robot)
        is_new = known is None or known.life != report.life or known.number < report.number
        return is_new and robot not in self.suspicion.suppressed(now_s)

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
        heard_s = self._heard_s
        lost = {robot for robot in owing if now_s - heard_s[robot] > silent_s}
        lost |= {robot for robot in self.counted if self.suspicion.has_gone(robot, heard_s[robot], now_s)}
        return sorted(lost - {own})

    def left_out(self, in_place: Collection[int], tried: Set[int], now_s: float) -> dict[int, str]:
        """Each robot of the mission that is not in place, and why; for people: this decides nothing."""
        others = (each for each in range(1, self.robots + 1) if each not in in_place)
        return {each: self._why_left_out(each, tried, now_s) for each in others}

    def _why_left_out(self, robot: int, tried: Set[int], now_s: float) -> str:
        """The first reason that holds."""
        presence = self.suspicion.presence
        if robot in self.counted:
            is_tried = robot in tried
            return "it has had its turn, and found no way to a place" if is_tried else "its turn has not come"
        if robot in self.suspicion.suppressed(now_s):
            return TOO_SILENT
        if presence.shows(robot):
            return "its report came too late" if robot in self.said else UNREPORTED
        return "its token has gone" if presence.was_seen(robot) else "its token has never come"
