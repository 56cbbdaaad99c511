"""What one robot says in a lining up, and what it knows of the others.

It announces itself on every change, and again and again; so any announcement may be lost. All others wait
for it, so it does that as often as all can hear each other, and in large fleets on every heartbeat.
"""

import math

import numpy as np
from msgspec.structs import replace

from agents.commands import Announce, Command
from agents.due import is_due
from agents.membership.muster import Roster
from agents.navigation.scan import View
from agents.strand.strand import URGENT_S
from protocol.arrays import Floats
from protocol.frames import Pose
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M
from protocol.wire.messages import Attempt, Muster, Turn

HEARD_PER_S = 100.0  # announcements, by each robot: what ten say that speak with every odometry


class Announcer:
    """One robot's announcements, and the newest of the others."""

    def __init__(
        self,
        robot: int,
        mission: Mission,
        *,
        epoch: int,
        named: tuple[int, ...],
        members: tuple[int, ...],
        attempt: Attempt,
    ) -> None:
        self.robot = robot
        self._mission = mission
        least_m = 2.0 * mission.robot_radius_m + mission.separation_m - TOUCHING_M
        self.roster = Roster(members, mission.goal, least_m, attempt)
        self.said = Muster(
            number=0,
            epoch=epoch,
            pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
            members=named,
            attempt=attempt,
        )
        often_s = max(URGENT_S, len(members) / HEARD_PER_S)
        self._again_s = min(often_s, mission.heartbeat_s)
        self._announced = 0
        self._announced_at_s = -math.inf
        self.look: View | None = None
        """A scan from where the robot stands, without the hulls of others; None where it has taken none."""

    @property
    def has_spoken(self) -> bool:
        """Whether it has announced anything."""
        return self._announced > 0

    def say(self, **news: object) -> None:
        """Have the next announcement say so; a robot is the first to hear itself."""
        if any(getattr(self.said, name) != value for name, value in news.items()):
            self.said = replace(self.said, **{"number": self.said.number + 1, **news})
            self.roster.hear(self.robot, self.said)

    def announce(self, now_s: float) -> list[Command]:
        """Say what is new, or that nothing is."""
        if self.said.number == self._announced:
            if not is_due(last_s=self._announced_at_s, every_s=self._again_s, now_s=now_s):
                return []
            self.say(number=self.said.number + 1)
        self._announced, self._announced_at_s = self.said.number, now_s
        # The clock of who misses much lags, but not for long: it hears nothing else either.
        echo_s = self.roster.mover_said_s(now_s + self._mission.silence_s)
        return [Announce(replace(self.said, t_s=now_s, echo_s=echo_s))]

    @property
    def places(self) -> dict[int, Pose]:
        """Where all robots stand."""
        places = self.roster.places
        assert places is not None, "nobody takes a place before all are known"
        return places

    @property
    def own_turn(self) -> Turn | None:
        """The turn that this robot has and has not ended."""
        turn = self.roster.turn
        if turn is None or turn.robot != self.robot:
            return None
        if self.robot in self.roster.strand and turn != self.said.gives:
            return None
        return turn if turn.number > self.said.ended else None

    @property
    def others(self) -> list[int]:
        """All robots but this one."""
        return [robot for robot in self.places if robot != self.robot]

    def xy_of(self, robots: list[int] | tuple[int, ...]) -> Floats:
        """Where robots stand (n, 2) [m; world frame]."""
        places = self.places
        return np.array([(places[robot].x_m, places[robot].y_m) for robot in robots]).reshape(-1, 2)
