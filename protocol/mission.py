"""The mission: all that a robot is told before it starts, and nothing of the obstacles."""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import ROBOTS_MAX, Length, Metres, Point, Seconds, Speed

DEADMAN_S = 1.0  # ten odometry periods: docs/run.md
WATCH_S = (
    0.3  # a scan each odometry, its answer, and the order: a robot that is sure of so long never has to stop
)


class Law(StrEnum):
    """The rule that makes a switching step out of a scan."""

    PRINTED = "printed"  # equation (14) as the paper prints it
    RESULTANT = "resultant"  # the sum of vectors that its text and Figure 2 describe
    CERTIFIED = "certified"  # clearance promised for the whole motion, before it is driven

    @property
    def promises_clearance(self) -> bool:
        """Whether a run under this law is judged by `epsilon - mu0`, or only by contact."""
        return self is Law.CERTIFIED


class Bounds(Struct, frozen=True, kw_only=True):
    """The rectangle that no hull may leave [m; world frame]."""

    x_m_min: Metres
    y_m_min: Metres
    x_m_max: Metres
    y_m_max: Metres


class Mission(Struct, frozen=True, kw_only=True, tag="mission"):
    """What every robot of a run is told: its size, its senses, the law, the promises, the goal."""

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
    """How many, interlaced, make a scan that is sure to show every obstacle out to `range_m_max`."""
    range_m_max: Length
    range_error_m_max: Length
    """No range is off by more than this."""
    blind_per_range: Annotated[float, Meta(ge=0.0, le=10.0)]
    """How far an obstacle may reach unseen past a ray that hit it, per metre of range, in such a scan."""
    link_length_m_max: Length
    """A robot holds while its follower is further than this behind what it has been granted."""
    goal: Point | None = None
    goal_tolerance_m: Length = 0.0
    bounds: Bounds | None = None
    switching_positions_max: Annotated[int, Meta(ge=1, le=2**53)] | None = None
    """Without a goal the leader stops at this many switching positions (the paper stops at 11)."""
    obstacle_speed_mps_max: Speed = 0.0
    """No obstacle moves faster; 0: nothing moves."""

    @property
    def obstacles_move(self) -> bool:
        """Whether a robot has to look while it drives."""
        return self.obstacle_speed_mps_max > 0.0 and self.law.promises_clearance

    @property
    def clear_m(self) -> float:
        """What a way keeps from whatever stands there: epsilon, or the separation, as it may be a robot."""
        return max(self.epsilon_m, self.separation_m)

    @property
    def berth_m(self) -> float:
        """Least distance of a robot's centre from an obstacle that a step is planned with.

        Where obstacles move it is more: nearer to anything, no motion could be promised for long enough.
        """
        moved_m = WATCH_S * self.obstacle_speed_mps_max if self.obstacles_move else 0.0
        return self.robot_radius_m + max(self.clear_m, moved_m + self.mu0_m + self.range_error_m_max)

    def blind_per_range_in(self, rays: int) -> float:
        """How far an obstacle may reach unseen, per metre of range, in a scan of so many rays."""
        return self.blind_per_range * self.directions * self.revolutions / rays

    @property
    def robot_keep_m(self) -> float:
        """Least distance between the centres of two robots that ground is granted for.

        The tolerance on top of the separation is what two robots may be off their path.
        """
        return 2.0 * self.robot_radius_m + self.separation_m + self.mu0_m

    @property
    def hull_reach_m(self) -> float:
        """How far from its place on the path a hit may be on a robot's hull.

        Twice the tolerance beyond its radius: it may be that far off its path, and the scan's place too.
        """
        return self.robot_radius_m + 2.0 * self.mu0_m

    heartbeat_s: Seconds = 0.25
    silence_s: Seconds = 1.0  # four lost heartbeats
    deadman_s: Seconds = DEADMAN_S
    patience_s: Seconds = 3.0  # with who shows a token and is not heard: three times silence
