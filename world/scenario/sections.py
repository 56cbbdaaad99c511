"""The sections of a scenario file, with the bounds of each number. Relations are in `checks`."""

import math
from typing import Annotated, Literal

from msgspec import Meta, Struct

from protocol.frames import ROBOTS_MAX, SPEED_MPS_MAX, Length, Metres, Pose, Radians, wrap
from protocol.mission import CERTIFIED, DIRECTIONS_MIN, RAYS_MAX, LawName, promises_clearance

Text = Annotated[str, Meta(max_length=2000)]
Place = Annotated[
    tuple[Metres, Metres, Radians], Meta(description="x, y [m], heading [rad] in -pi to pi; world frame")
]
Places = Annotated[tuple[Place, ...], Meta(min_length=1, max_length=ROBOTS_MAX)]
SomeMetres = Annotated[float, Meta(gt=0.0, le=1e4, description="m")]
TIME_S_MAX = 1e6  # twelve days
SomeSpeed = Annotated[float, Meta(gt=0.0, le=SPEED_MPS_MAX)]


class _Section(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The base of all sections: unknown fields are errors."""


class Fleet(_Section, frozen=True, kw_only=True):
    """The robots and their places: a list (`places`), a queue (`start`, `spacing_m`) or `deployment`."""

    robots: Annotated[int, Meta(ge=1, le=ROBOTS_MAX, description="number of robots; `-n` overrides it")]
    robot_radius_m: Annotated[Length, Meta(description="m, radius of a robot's disc; 0 is a point")]
    separation_m: Annotated[Length, Meta(description="m, least allowed distance between hulls")]
    link_length_m_max: Annotated[
        SomeMetres, Meta(description="m, a robot waits while the robot behind lags further than this")
    ]
    places: Annotated[
        Places | None, Meta(description="place of each robot, robot 1 first; instead of a queue")
    ] = None
    start: Annotated[Place | None, Meta(description="place and heading of robot 1 in a queue")] = None
    spacing_m: Annotated[
        SomeMetres | None,
        Meta(description="m, robot k stands (k - 1) of these behind `start`, against its heading"),
    ] = None
    deployment: Annotated[
        Literal["random"] | None,
        Meta(description="`random`: the seed draws the places, unless `places` gives them; `--deployment`"),
    ] = None

    def poses(self) -> tuple[Pose, ...]:
        """The initial pose of each robot, robot 1 first."""
        if self.places is not None:
            return tuple(_pose(*place) for place in self.places[: self.robots])
        assert self.start is not None
        assert self.spacing_m is not None
        x_m, y_m, heading_rad = self.start
        back_x_m, back_y_m = self.spacing_m * math.cos(heading_rad), self.spacing_m * math.sin(heading_rad)
        return tuple(_pose(x_m - k * back_x_m, y_m - k * back_y_m, heading_rad) for k in range(self.robots))


def _pose(x_m: float, y_m: float, heading_rad: float) -> Pose:
    return Pose(x_m=x_m, y_m=y_m, heading_rad=wrap(heading_rad))


class LawSection(_Section, frozen=True, kw_only=True):
    """The law of the leader and the clearance to keep."""

    law: Annotated[
        LawName,
        Meta(
            description="the rule that makes a switching step from a scan: `certified`, `printed`, "
            "`resultant`, one of an installed package, or `FILE.py:NAME`; `--law` overrides it"
        ),
    ] = CERTIFIED
    epsilon_m: Annotated[SomeMetres, Meta(description="m, least clearance from hull to obstacle")]
    mu0_m: Annotated[Length, Meta(description="m, tolerance of the clearance; must cover the error budget")]

    @property
    def promises_clearance(self) -> bool:
        """Whether every step has a certificate."""
        return promises_clearance(self.law)


class Goal(_Section, frozen=True, kw_only=True):
    """The goal of the leader."""

    at_m: Annotated[tuple[Metres, Metres], Meta(description="position: x, y [m; world frame]")]
    tolerance_m: Annotated[SomeMetres, Meta(description="m, largest distance of the leader's centre from it")]


class SensorSection(_Section, frozen=True, kw_only=True):
    """The range sensor that every body carries."""

    directions: Annotated[
        int, Meta(ge=DIRECTIONS_MIN, le=RAYS_MAX, description="rays per revolution, evenly spaced")
    ]
    range_m_max: Annotated[SomeMetres, Meta(description="m, range limit")]
    range_sigma_m: Annotated[
        Length, Meta(description="m, standard deviation of a range; errors are clipped at 3 sigma")
    ] = 0.0


class DriveSection(_Section, frozen=True, kw_only=True):
    """The speeds and errors of the drives; equation (1) of the paper requires v_min < v < v_max."""

    speed_mps: Annotated[SomeSpeed, Meta(description="m/s, speed of the robots (v); bodies refuse more")]
    speed_mps_min: Annotated[
        float, Meta(ge=0.0, le=SPEED_MPS_MAX, description="m/s, bodies refuse this speed and below (v_min)")
    ]
    speed_mps_max: Annotated[SomeSpeed, Meta(description="m/s, limit of the drives (v_max), above speed_mps")]
    turn_rate_radps: Annotated[float, Meta(gt=0.0, le=100.0, description="rad/s, turn rate on the spot")]
    heading_error_rad: Annotated[
        float, Meta(ge=0.0, le=0.1, description="rad, largest error of a body's heading")
    ] = 0.0


class TimeSection(_Section, frozen=True, kw_only=True):
    """The time limit of a run."""

    time_s_max: Annotated[
        float,
        Meta(
            gt=0.0, le=TIME_S_MAX, description="s, simulated; the run fails after this time; `--time-s-max`"
        ),
    ]
