"""A robot's questions to its sensor: asked until answered, and an answer is believed once.

A question or its answer may be lost, and one that was repeated may be answered twice, the second time when
the robot stands somewhere else. So a scan is good only where it was taken. And who has been left out of a
muster may have moved since: it stands from a known time on, and only scans from then on are good.
"""

from agents.body.driver import Driver
from agents.commands import AskScan, Command
from agents.due import is_due
from agents.navigation.scan import View, view
from protocol.mission import Mission
from protocol.wire.messages import Scan

RETRY_S = 0.2  # the sensor itself answers within a tick, and the way there and back takes milliseconds


class Senses:
    """The scan that a robot waits for."""

    def __init__(self, mission: Mission, driver: Driver) -> None:
        self._mission = mission
        self._driver = driver
        self._scan: Scan | None = None
        self._asked_at_s = -float("inf")
        self._trusted_from_s = -float("inf")

    def hear(self, scan: Scan) -> None:
        """Take in what the sensor answers."""
        self._scan = scan

    def forget(self) -> None:
        """What has been seen so far is not to be believed any more."""
        self._scan = None

    def trust_from(self, since_s: float) -> None:
        """Whoever is not in the strand stands since then: no scan that is older is believed any more."""
        self._trusted_from_s = max(self._trusted_from_s, since_s)

    def ask(self, now_s: float, *, revolutions: int | None = None) -> list[Command]:
        """Ask for a scan, if not just asked: as usual, or of so many revolutions."""
        if not is_due(last_s=self._asked_at_s, every_s=RETRY_S, now_s=now_s):
            return []
        self._asked_at_s = now_s
        return [AskScan(revolutions or self._mission.revolutions)]

    def look(self, now_s: float) -> list[Command]:
        """Ask again, whatever is still on its way: where obstacles move a robot looks while it drives."""
        self._asked_at_s = now_s
        return [AskScan(self._mission.revolutions)]

    def glimpse(self, since_s: float) -> tuple[View, float] | None:
        """A scan that has come and was taken since then, wherever the robot was; and when. Used once."""
        scan, self._scan = self._scan, None
        if scan is None or scan.t_s < since_s:
            return None
        return view(scan, range_m_max=self._mission.range_m_max), scan.t_s

    def take(self, *, revolutions: int = 1) -> View | None:
        """The scan that has come, if it was taken here and is as fine as that. It is used once."""
        scan, self._scan = self._scan, None
        if scan is None or scan.t_s < self._trusted_from_s or scan.pose != self._driver.odometry.pose:
            return None
        if len(scan.ranges_m) < revolutions * self._mission.directions:
            return None
        self._asked_at_s = -float("inf")
        return view(scan, range_m_max=self._mission.range_m_max)
