"""The mission: everything that a robot knows before it starts. It contains no obstacles."""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import ROBOTS_MAX, Length, Metres, Point, Seconds, Speed

DEADMAN_S = 1.0  # ten odometry periods: docs/run.md
WATCH_S = 0.3  # odometry, scan, order: a robot whose motion is safe for this long never has to stop

START_WALL_S = (
    30.0  # five robots beside 40 busy processes on two cores came after 15 s; on idle ones in 0.5 s
)
START_WALL_S_PER_ROBOT = 0.5  # fifty robots come within 2 s on two idle cores

BLIND_PER_RANGE_MAX = 10.0
"""More than any range: beside a corner that two rays may hide whole, nothing is certified."""


def start_wall_s(robots: int) -> float:
    """How long the robots of a fleet of this size may take to come [wall s]."""
    return START_WALL_S + START_WALL_S_PER_ROBOT * robots


class Law(StrEnum):
    """The rule that makes a switching step out of a scan."""

    PRINTED = "printed"  # equation (14) as the paper prints it
    RESULTANT = "resultant"  # the sum of vectors in the paper's text and Figure 2
    CERTIFIED = "certified"  # clearance promised for the whole motion before it begins

    @property
    def promises_clearance(self) -> bool:
        """Whether runs under this law are judged by `epsilon - mu0`, or only by contact."""
        return self is Law.CERTIFIED


class Bounds(Struct, frozen=True, kw_only=True):
    """The rectangle that no hull may leave [m; world frame]."""

    x_m_min: Metres
    y_m_min: Metres
    x_m_max: Metres
    y_m_max: Metres


class Mission(Struct, frozen=True, kw_only=True, tag="mission"):
    """The mission of every robot in a run: its size, its sensor, the law, the promises, the goal."""

    robots: Annotated[int, Meta(ge=1, le=ROBOTS_MAX)]
    robot_radius_m: Length
    law: Law
    epsilon_m: Length
    mu0_m: Length
    separation_m: Length
    speed_mps: Speed
    directions: Annotated[int, Meta(ge=8, le=7200)]
    """Rays of one revolution of the scanner."""
    revolutions: Annotated[int, Meta(ge=1, le=900)]
    """How many interlaced revolutions are sure to show every obstacle out to `range_m_max`."""
    range_m_max: Length
    range_error_m_max: Length
    """The largest error of a range."""
    blind_per_range: Annotated[float, Meta(ge=0.0, le=BLIND_PER_RANGE_MAX)]
    """How far an obstacle can extend unseen past a ray that hit it, per metre of range, in such a scan."""
    link_length_m_max: Length
    """A robot waits while its follower is further than this behind its movement authority."""
    goal: Point | None = None
    goal_tolerance_m: Length = 0.0
    bounds: Bounds | None = None
    switching_positions_max: Annotated[int, Meta(ge=1, le=2**53)] | None = None
    """Without a goal the leader stops after this many switching positions (the paper stops at 11)."""
    obstacle_speed_mps_max: Speed = 0.0
    """The top speed of any obstacle; 0: nothing moves."""

    @property
    def obstacles_move(self) -> bool:
        """Whether a robot has to take scans while it drives."""
        return self.obstacle_speed_mps_max > 0.0 and self.law.promises_clearance

    @property
    def clear_m(self) -> float:
        """The distance to keep from any hit: epsilon or the separation, since the hit may be a robot."""
        return max(self.epsilon_m, self.separation_m)

    @property
    def obstacle_keep_m(self) -> float:
        """The least distance between a robot's centre and an obstacle in a planned step.

        It is larger where obstacles move: closer to a hit, no motion is safe for long enough.
        """
        moved_m = WATCH_S * self.obstacle_speed_mps_max if self.obstacles_move else 0.0
        return self.robot_radius_m + max(self.clear_m, moved_m + self.mu0_m + self.range_error_m_max)

    @property
    def leg_m_max(self) -> float:
        """The longest way between neighbours in a strand that forms: what a robot sees, and may lag."""
        return min(self.link_length_m_max, self.range_m_max)

    def blind_per_range_in(self, rays: int) -> float:
        """How far an obstacle can extend unseen, per metre of range, in a scan with this many rays."""
        return self.blind_per_range * self.directions * self.revolutions / rays

    @property
    def robot_keep_m(self) -> float:
        """The least distance between the centres of two robots for which ground is granted.

        The tolerance is added to the separation because two robots may be off their path.
        """
        return 2.0 * self.robot_radius_m + self.separation_m + self.mu0_m

    @property
    def hull_reach_m(self) -> float:
        """The largest distance between a robot's place on the path and a hit on its hull.

        It is the radius and twice the tolerance: the robot and the scan's position may both be off.
        """
        return self.robot_radius_m + 2.0 * self.mu0_m

    @property
    def way_of_heartbeats_m(self) -> float:
        """How far a robot that was heard lately may have driven since: the way of two heartbeats."""
        return 2.0 * self.heartbeat_s * self.speed_mps

    heartbeat_s: Seconds = 0.25
    silence_s: Seconds = 1.0  # four lost heartbeats
    deadman_s: Seconds = DEADMAN_S
    patience_s: Seconds = 3.0  # limit for a silent robot that still shows a token: three times `silence_s`
