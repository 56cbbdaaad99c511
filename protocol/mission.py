"""The mission: everything that a robot knows before it starts. It contains no obstacles."""

import math
from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import ROBOTS_MAX, Length, Metres, Point, Pose, Seconds, Speed

DEADMAN_S = 1.0  # ten odometry periods: docs/run.md
WATCH_S = 0.3  # odometry, scan, order: a robot whose motion is safe for this long never has to stop
MOVES_S = 0.05  # two ticks, order and one to move in, to a hundredth: who may not do that cannot move
BRIEF_S = 0.06  # three of the world's ticks: scan, order, and one to move in
RAYS_MAX = 7200  # per scan: 58 kB on the wire
DIRECTIONS_MIN = 8  # of one revolution
REVOLUTIONS_MAX = RAYS_MAX // DIRECTIONS_MIN
DRIVE_SHARE = 0.25  # of the tolerance: what one drive may be off (`world/scenario/budget.py`)
SEEN_SHARE = 1.0 - 2.0 * DRIVE_SHARE  # of the tolerance; the rest is for two drives' errors

START_WALL_S = (
    30.0  # five robots beside 40 busy processes on two cores came after 15 s; on idle ones in 0.5 s
)
START_WALL_S_PER_ROBOT = 0.5  # fifty robots come within 2 s on two idle cores


def start_wall_s(robots: int) -> float:
    """How long the robots of a fleet of this size may take to start [wall s]."""
    return START_WALL_S + START_WALL_S_PER_ROBOT * robots


LAW_NAME = r"[a-z][a-z0-9_-]*"
LawName = Annotated[
    str,
    Meta(
        pattern=f"^({LAW_NAME}|[^:]+[.]py:[A-Za-z0-9_@]+)$",
        max_length=200,
        extra={"words": "a law's name as certified, or FILE.py:NAME, of at most 200 characters"},
    ),
]
"""A law of ours, of a package or of Python code; or one of a file (`protocol/law_files.py`)."""
CERTIFIED = "certified"
UNCERTIFIED = frozenset({"printed", "resultant"})
"""The paper's laws drive as the paper says, without a certificate; no other law can."""


def promises_clearance(law: str) -> bool:
    """Whether runs under this law are judged by `epsilon - mu0`, or only by contact."""
    return law not in UNCERTIFIED


class Bounds(Struct, frozen=True, kw_only=True):
    """The rectangle that no hull may leave [m; world frame]."""

    x_m_min: Metres
    y_m_min: Metres
    x_m_max: Metres
    y_m_max: Metres

    def nearest(self, place: Pose | Point) -> Point:
        """The point in it that is nearest to a place."""
        return Point(
            x_m=min(max(place.x_m, self.x_m_min), self.x_m_max),
            y_m=min(max(place.y_m, self.y_m_min), self.y_m_max),
        )

    def inset(self, by_m: float) -> "Bounds":
        """The rectangle inside this one whose sides are `by_m` from its own."""
        return Bounds(
            x_m_min=self.x_m_min + by_m,
            y_m_min=self.y_m_min + by_m,
            x_m_max=self.x_m_max - by_m,
            y_m_max=self.y_m_max - by_m,
        )


def robot_keep_m(
    *, robot_radius_m: float, separation_m: float, mu0_m: float, obstacle_speed_mps_max: float
) -> float:
    """See `Mission.robot_keep_m`."""
    moment_m = BRIEF_S * obstacle_speed_mps_max + mu0_m if obstacle_speed_mps_max > 0.0 else 0.0
    return 2.0 * robot_radius_m + max(separation_m, moment_m) + mu0_m


class Mission(Struct, frozen=True, kw_only=True, tag="mission"):
    """The mission of every robot in a run: its size, its sensor, the law, the promises, the goal."""

    robots: Annotated[int, Meta(ge=1, le=ROBOTS_MAX)]
    robot_radius_m: Length
    law: LawName
    epsilon_m: Length
    mu0_m: Length
    separation_m: Length
    speed_mps: Speed
    directions: Annotated[int, Meta(ge=DIRECTIONS_MIN, le=RAYS_MAX)]
    """Rays of one revolution of the scanner."""
    revolutions: Annotated[int, Meta(ge=1, le=REVOLUTIONS_MAX)]
    """How many interlaced revolutions are sure to show every obstacle out to `range_m_max`."""
    range_m_max: Length
    range_error_m_max: Length
    """The largest error of a range."""
    sharpest_corner_rad: Annotated[float, Meta(gt=0.0, le=math.pi / 2)]
    """No corner of an obstacle that a ray can meet is sharper; a right angle if all are blunt."""
    link_length_m_max: Length
    """A robot waits while its follower is further than this behind its movement authority."""
    goal: Point | None = None
    goal_tolerance_m: Length = 0.0
    bounds: Bounds | None = None
    switching_positions_max: Annotated[int, Meta(ge=1, le=2**53)] | None = None
    """Without a goal the leader stops after this many switching positions (the paper stops at 11)."""
    obstacle_speed_mps_max: Speed = 0.0
    """The top speed of any obstacle; 0: nothing moves."""
    watch_s: Seconds = WATCH_S
    """Where obstacles move, a step is planned so that a motion on it is safe for this long at any time."""
    heartbeat_s: Seconds = 0.25
    """How often a link state is sent at least."""
    silence_s: Seconds = 1.0  # four lost heartbeats
    """A neighbour that was not heard for so long is silent."""
    deadman_s: Seconds = DEADMAN_S
    """A body stops if its robot was silent for so long."""

    @property
    def promises_clearance(self) -> bool:
        """Whether every step has a certificate."""
        return promises_clearance(self.law)

    @property
    def obstacles_move(self) -> bool:
        """Whether a robot has to take scans while it drives."""
        return self.obstacle_speed_mps_max > 0.0 and self.promises_clearance

    @property
    def clear_m(self) -> float:
        """The distance to keep from any hit: epsilon or the separation, since the hit may be a robot."""
        return max(self.epsilon_m, self.separation_m)

    @property
    def obstacle_keep_m(self) -> float:
        """The least distance between a robot's centre and an obstacle in a planned step.

        It is larger where obstacles move: closer to a hit, no motion is safe for long enough.
        """
        moved_m = self.watch_s * self.obstacle_speed_mps_max if self.obstacles_move else 0.0
        return self.robot_radius_m + max(self.clear_m, moved_m + self.mu0_m + self.range_error_m_max)

    @property
    def path_bounds(self) -> Bounds | None:
        """The rectangle in which a strand's path is laid, so that no drive's error leads out of the bounds.

        The loader refuses bounds that leave none. None: there are no bounds, or nothing is promised.
        """
        bounds = self.bounds
        if bounds is None or not self.promises_clearance:
            return None
        return bounds.inset(self.robot_radius_m + DRIVE_SHARE * self.mu0_m)

    @property
    def closest_rays(self) -> int:
        """The rays of the closest look: of as many whole revolutions as a scan may have."""
        return RAYS_MAX // self.directions * self.directions

    @property
    def leg_m_max(self) -> float:
        """The longest way between neighbours in a strand that forms: what a robot sees, and may lag.

        The closest look from one end is sure of all that is nearer to the way than a robot keeps, up to
        beside its far end.
        """
        share = self.sure_share_in(self.closest_rays)
        sure_m = share * (self.range_m_max - self.range_error_m_max)
        seen_m = math.sqrt(max(0.0, sure_m**2 - self.obstacle_keep_m**2))
        return min(self.link_length_m_max, seen_m)

    def sure_share_in(self, rays: int, *, bodies_only: bool = False) -> float:
        """How near the sensor a corner can reach unseen between two rays: at this share of the nearer one.

        `agents/navigation/sure.py` derives it. Rays that a whole corner fits between show nothing: 0.
        For robots' bodies it is less (rule 4 there).
        """
        corner_rad = math.pi / 2.0 if bodies_only else self.sharpest_corner_rad
        half_rad, half_spacing_rad = corner_rad / 2.0, math.pi / rays
        return max(0.0, math.sin(half_rad - half_spacing_rad) / math.sin(half_rad))

    @property
    def robot_keep_m(self) -> float:
        """The least distance between the centres of two robots of a strand.

        The tolerance is added to the separation because two robots may be off their path. It is larger where
        obstacles move: one may be hidden behind the other robot, and nearer to it no moment is safe.
        """
        return robot_keep_m(
            robot_radius_m=self.robot_radius_m,
            separation_m=self.separation_m,
            mu0_m=self.mu0_m,
            obstacle_speed_mps_max=self.obstacle_speed_mps_max if self.obstacles_move else 0.0,
        )

    @property
    def grant_keep_m(self) -> float:
        """The distance of granted ground from the centre of a robot that may still be there.

        Besides `robot_keep_m`, hulls are left epsilon apart: where one robot dies, it is an obstacle, and no
        certified step leads past what is nearer.
        """
        apart_m = self.epsilon_m if self.promises_clearance else 0.0
        return max(self.robot_keep_m, 2.0 * self.robot_radius_m + apart_m + self.mu0_m)

    @property
    def drive_off_rad(self) -> float:
        """How far a drive may be off its heading at most; the loader checks it (`DRIVE_SHARE`)."""
        return DRIVE_SHARE * self.mu0_m / self.range_m_max

    @property
    def moves_off_m(self) -> float:
        """The least distance of a robot's centre from anything in sight at which it may move at all.

        Where obstacles move, one may be hidden behind that, or in front of it between two rays.
        """
        if not self.obstacles_move:
            return self.robot_radius_m
        sure_m = self.robot_radius_m + self.mu0_m + MOVES_S * self.obstacle_speed_mps_max
        share = self.sure_share_in(self.directions * self.revolutions)
        return self.range_error_m_max + (sure_m / share if share > 0.0 else math.inf)

    @property
    def moves_beside_m(self) -> float:
        """The least distance between the centres of two robots at which one of them may move at all."""
        return self.robot_radius_m + self.moves_off_m

    @property
    def hull_reach_m(self) -> float:
        """How far off the ground where a robot may be hits are taken for its hull.

        It is the robot's radius and `mu0`, which is more than the robot can be off and the range error. A
        robot that keeps `robot_keep_m` from that ground keeps the separation from a hull there that is
        another's (F6). No ray meets a point, so every hit near a robot of radius 0 is of something else.
        """
        return self.robot_radius_m + self.mu0_m if self.robot_radius_m > 0.0 else 0.0
