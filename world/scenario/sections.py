"""The sections of a scenario file; what each number may be by itself. Relations are in `checks`."""

import math
from typing import Annotated, Literal

from msgspec import Meta, Struct

from protocol.frames import ROBOTS_MAX, Length, Metres, Pose, Radians, wrap
from protocol.mission import Law

Text = Annotated[str, Meta(max_length=2000)]
Place = Annotated[
    tuple[Metres, Metres, Radians], Meta(description="x, y [m], heading [rad] in -pi to pi; world frame")
]
Places = Annotated[tuple[Place, ...], Meta(min_length=1, max_length=ROBOTS_MAX)]
SomeMetres = Annotated[float, Meta(gt=0.0, le=1e4, description="m")]
SomeSpeed = Annotated[float, Meta(gt=0.0, le=100.0)]


class _Section(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What all sections share: a misspelt field is an error."""


class Fleet(_Section, frozen=True, kw_only=True):
    """The robots and where they start: `places` one by one, queued from `start` by `spacing_m`, or at random.

    A queue extends backwards: robot k stands (k - 1) `spacing_m` behind `start`, against its heading.
    """

    robots: Annotated[
        int, Meta(ge=1, le=ROBOTS_MAX, description="how many robots there are; `-n` says another number")
    ]
    robot_radius_m: Annotated[Length, Meta(description="m, of the disc that a robot is; 0 is a point")]
    separation_m: Annotated[Length, Meta(description="m, least allowed hull to hull")]
    link_length_m_max: Annotated[
        SomeMetres, Meta(description="m, a robot holds while the one behind lags further")
    ]
    places: Annotated[
        Places | None, Meta(description="where each robot starts, robot 1 first; if there is no queue")
    ] = None
    start: Annotated[Place | None, Meta(description="where robot 1 of a queue starts, and its heading")] = (
        None
    )
    spacing_m: Annotated[
        SomeMetres | None, Meta(description="m, from centre to centre along the queue, away from `start`")
    ] = None
    deployment: Annotated[
        Literal["random"] | None,
        Meta(description="`random`: the seed draws the places, unless they are said; `--deployment`"),
    ] = None

    def poses(self) -> tuple[Pose, ...]:
        """Where each robot starts, robot 1 first."""
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
    """The law of the leader and the clearance that it is to keep."""

    law: Annotated[
        Law, Meta(description="the rule that makes a switching step out of a scan; `--law` says another")
    ] = Law.CERTIFIED
    epsilon_m: Annotated[SomeMetres, Meta(description="m, least clearance from hull to obstacle")]
    mu0_m: Annotated[Length, Meta(description="m, tolerance on it; it has to cover the error budget")]


class Goal(_Section, frozen=True, kw_only=True):
    """Where the leader has to get to."""

    at_m: Annotated[tuple[Metres, Metres], Meta(description="where it is: x, y [m; world frame]")]
    tolerance_m: Annotated[SomeMetres, Meta(description="m, how near the leader's centre has to come")]


class SensorSection(_Section, frozen=True, kw_only=True):
    """The range sensor that every body carries."""

    directions: Annotated[int, Meta(ge=8, le=7200, description="rays of a scan, evenly spread")]
    range_m_max: Annotated[SomeMetres, Meta(description="m, how far it sees")]
    range_sigma_m: Annotated[
        Length, Meta(description="m, standard deviation of a range; errors are clipped at three")
    ] = 0.0


class DriveSection(_Section, frozen=True, kw_only=True):
    """How bodies drive, and how well: equation (1) of the paper wants v_min < v < v_max."""

    speed_mps: Annotated[SomeSpeed, Meta(description="m/s, at which robots drive")]
    speed_mps_min: Annotated[
        float, Meta(ge=0.0, le=100.0, description="m/s, a body takes no order for less; v_min")
    ]
    speed_mps_max: Annotated[SomeSpeed, Meta(description="m/s, a body takes no order for more; v_max")]
    turn_rate_radps: Annotated[
        float, Meta(gt=0.0, le=100.0, description="rad/s, at which bodies turn on the spot")
    ]
    heading_error_rad: Annotated[
        float, Meta(ge=0.0, le=0.1, description="rad, most that a body is off the heading it wants")
    ] = 0.0


class TimeSection(_Section, frozen=True, kw_only=True):
    """How long a run may take."""

    time_s_max: Annotated[
        float, Meta(gt=0.0, le=1e6, description="s, simulated; the run fails when they have passed")
    ]
