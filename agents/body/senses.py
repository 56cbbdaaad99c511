"""A robot's scan queries: repeated until answered, and each answer is used once.

A query or its answer may be lost. A repeated query may be answered twice, the second time when the robot
stands somewhere else.

Rule 1: a scan of a standing robot is valid only where it was taken.
Rule 2 (F6 of docs/strand.md): a scan serves only under the very fence that it bears, turn included, and only
        if that is in force. Under an older one, other robots may have moved since.
Rule 3: a scan that shows too little to decide may be followed by a closer one from there, with more
        revolutions of the scanner. The scan after that has as many as usual.
Rule 4 (liveness): a robot asks only when it hears something. One that hears little, or nothing for a while,
        makes up for the queries that it would have repeated meanwhile.
"""

from agents.body.driver import Driver
from agents.commands import AskScan, Command
from agents.due import is_due
from agents.navigation.scan import View, view
from agents.navigation.sure import closer
from protocol.fence import in_force
from protocol.mission import Mission
from protocol.wire.messages import Scan

RETRY_S = 0.2  # the sensor answers within a tick, and the messages take milliseconds
MADE_UP_MAX = 5  # queries at once: those of a second


class Senses:
    """The scan queries of a robot, and the newest answer."""

    def __init__(self, mission: Mission, driver: Driver) -> None:
        self._mission = mission
        self._driver = driver
        self._scan: Scan | None = None
        self._asked_at_s = -float("inf")
        self._is_answered = True
        """Whether no query is pending."""
        self._revolutions = mission.revolutions
        """Of the scan that is wanted next."""

    def hear(self, scan: Scan) -> None:
        """Adopt an answer of the sensor."""
        self._scan, self._is_answered = scan, True

    def forget(self) -> None:
        """Drop the scan that has arrived; it is no longer valid."""
        self._scan, self._is_answered = None, True

    def _serves(self, scan: Scan) -> bool:
        """Rule 2."""
        fence = self._driver.odometry.fence
        return scan.fence == fence and in_force(fence)

    def look_closer(self, than: View) -> bool:
        """Whether there is a closer look than this scan; if so, the next scan is one (rule 3)."""
        revolutions = closer(self._mission, len(than.ranges_m))
        self._revolutions = revolutions or self._mission.revolutions
        return revolutions is not None

    def ask(self, now_s: float) -> list[Command]:
        """Ask for a scan, unless just asked."""
        if not is_due(last_s=self._asked_at_s, every_s=RETRY_S, now_s=now_s):
            return []
        missed_s = 0.0 if self._is_answered else min(now_s - self._asked_at_s, MADE_UP_MAX * RETRY_S)
        self._asked_at_s, self._is_answered = now_s, False
        return [AskScan(self._revolutions)] * max(1, int(missed_s / RETRY_S))  # rule 4

    def look(self, now_s: float) -> list[Command]:
        """Ask for a scan even if a query is pending: where obstacles move, a robot scans while it drives."""
        self._asked_at_s = now_s
        return [AskScan(self._mission.revolutions)]

    def glimpse(self, since_s: float) -> tuple[View, float] | None:
        """The scan that has arrived and its time, if taken since then at any place. Each is used once."""
        scan, self._scan = self._scan, None
        if scan is None or scan.t_s < since_s or not self._serves(scan):
            return None
        return view(scan, range_m_max=self._mission.range_m_max), scan.t_s

    def take(self) -> View | None:
        """The scan that has arrived, if taken here with enough revolutions. Each is used once."""
        scan, self._scan = self._scan, None
        if scan is None or scan.pose != self._driver.odometry.pose or not self._serves(scan):
            return None
        if len(scan.ranges_m) < self._revolutions * self._mission.directions:
            return None
        self._asked_at_s, self._revolutions = -float("inf"), self._mission.revolutions
        return view(scan, range_m_max=self._mission.range_m_max)
