"""How far the robots are behind the world's clock, and whom the clock waits for. Pure.

All time-outs of robots are in simulated time, which is their only clock. So a clock that waits for a late
robot keeps the time-outs of all robots, its own and those of the robots that would hold it for dead.

Rule 1: the clock waits while a robot has not answered odometry that is older than `SLACK_S`.
Rule 2: it waits for a robot that shows a token for `PATIENCE_S` after its last answer; beside many, longer.
Rule 3: it waits for a robot without a token only as long as the lateness of the machine may explain that: a
        token also vanishes when a process has no time to keep its link alive. On an idle machine that is no
        time at all, so a process that has died is noticed as soon as ever.
Rule 4: it waits for nobody whose messages or process a fault holds up: that is meant.
"""

from collections.abc import Iterable, Iterator, Set
from dataclasses import dataclass, field

from protocol.network.lateness import Lateness

# Two cores take a second for one odometry each of 1,000 standing robots, and their answers.
ROBOTS_PER_INSTANT = 200
# 0.3 s: a robot that loses one odometry does not take itself for cut off (agents/liveness).
SHARES_MAX = 3
ROUNDING_S = 1e-9  # 0.9 - 0.6 is a little more than 0.3
SLACK_S = 0.3  # simulated: less than the 0.35 s after which a robot without a token is lost (agents/liveness)
PATIENCE_S = 10.0  # wall: five times the longest silence that was measured of a process on a busy machine
# Of 1,000 robots on two busy cores half took 18 s for an answer while all took a scan, and one took 40 s. The
# clock had gone on without them, so that all orders were void, and the strand did not form.
PATIENCE_S_PER_ROBOT = 0.04
LATE_TIMES = 10.0  # a link needs a turn every 0.25 s, and breaks after 1 s: a few late ones break it


def due(robots: Iterable[int], instant: int, *, in_all: int) -> set[int]:
    """Those of these robots that have odometry at this instant; with many robots in all, each more rarely."""
    shares = min(-(-in_all // ROBOTS_PER_INSTANT), SHARES_MAX)
    return {robot for robot in robots if robot % shares == instant % shares}


@dataclass(slots=True)
class Answers:
    """The newest odometry that was sent to each robot and the newest that it has answered."""

    robots: int = 1
    """How many share the machine."""
    lateness: Lateness = field(default_factory=Lateness)
    """The greatest of any process, the world's own included."""
    _told_s: dict[int, float] = field(default_factory=dict)
    _answered_s: dict[int, float] = field(default_factory=dict)
    _answered_wall_s: dict[int, float] = field(default_factory=dict)

    def begin(self, robots: Iterable[int], *, wall_s: float) -> None:
        """The clock starts: answers are awaited from now on."""
        self._answered_wall_s = dict.fromkeys(robots, wall_s)

    def tell(self, robot: int, now_s: float) -> None:
        """Odometry of this time is sent to a robot."""
        self._told_s[robot] = now_s

    def answer(self, robot: int, basis_s: float, *, late_s: float, wall_s: float) -> None:
        """A robot has answered odometry of this time, and says how late it runs."""
        self.lateness.hear(late_s, wall_s)
        if basis_s > self._answered_s.get(robot, -1.0):
            self._answered_s[robot] = basis_s
            self._answered_wall_s[robot] = wall_s

    def behind(self, *, slack_s: float = 0.0) -> Iterator[int]:
        """The robots that have not answered odometry that is older than this."""
        for robot, told_s in self._told_s.items():
            if told_s - self._answered_s.get(robot, -1.0) > slack_s + ROUNDING_S:
                yield robot

    def excused_s(self, *, wall_s: float) -> float:
        """For how long a process may be silent without a token because the machine is late [wall s]."""
        return min(PATIENCE_S, LATE_TIMES * self.lateness.now_s(wall_s))

    def late(self, living: Set[int], present: Set[int], *, wall_s: float) -> Iterator[int]:
        """The living robots that the clock waits for (rules 1 to 3); `present`: those that show a token."""
        for each in self.behind(slack_s=SLACK_S):  # one by one: often only the first matters
            if each in living and self.waits_for(each, shows_token=each in present, wall_s=wall_s):
                yield each

    def waits_for(self, robot: int, *, shows_token: bool, wall_s: float) -> bool:
        """Whether the clock still waits for the answer of a robot that is behind."""
        longest_s = max(PATIENCE_S, PATIENCE_S_PER_ROBOT * self.robots)
        patience_s = longest_s if shows_token else self.excused_s(wall_s=wall_s)
        return wall_s - self._answered_wall_s[robot] < patience_s
