"""The error budget: finite directions, sensor noise, drive errors and rounding.

The certificate covers what finite directions leave unseen: it takes for free only what the scan is sure of
(`agents/navigation/sure.py`). So ray quantisation costs room in narrow gaps, and almost nothing of the
tolerance mu0. A small share remains: a robot at that distance may drive along the obstacle, and what two rays
hide may then be one ray spacing ahead. Noise differs between scans, and drive errors between drives. mu0 has
to cover all of these shares.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from protocol.mission import DRIVE_SHARE
from protocol.path import THERE_M
from world.geometry.shapes import Shape

NOISE_SIGMAS = 3.0
"""The sensor clips its Gaussian error at so many sigmas: 99.7 % of errors are below."""

HEADING_ERRORS = 1.0 / DRIVE_SHARE
"""Heading errors that add up beside a path: the leader deviates from its plan, and a follower from both ends
of the segment that the leader drove. Two are what a check of bodies leaves to drives (`SEEN_SHARE`): one to
the robot's own, and one to that of a robot behind, from which the body may be hidden."""

ROUNDINGS = 4.0
"""Places along a path that count as equal though `THERE_M` apart: of two robots, each may turn so much before
a vertex, and drive so much beyond what is granted or checked."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """The shares of the error budget [m]."""

    quantisation_m: float
    """At the closest approach, in addition to the distance that the certificate keeps."""
    range_noise_m: float
    drive_m: float
    rounding_m: float = ROUNDINGS * THERE_M

    @property
    def total_m(self) -> float:
        """The sum that mu0 has to cover."""
        return self.quantisation_m + self.range_noise_m + self.drive_m + self.rounding_m


def sure_range_m(shapes: Sequence[Shape], directions: int) -> float:
    """The range out to which none of these fits between two rays; inf if there are none."""
    thinnest_m = min((shape.smallest_width_m for shape in shapes), default=math.inf)
    return thinnest_m / (math.tau / directions)


def revolutions(shapes: Sequence[Shape], directions: int, *, wanted_m: float, rays_max: int) -> int:
    """Interlaced revolutions that are sure to show every obstacle out to `wanted_m`, within `rays_max`."""
    needed = math.ceil(wanted_m / sure_range_m(shapes, directions))
    return max(1, min(needed, rays_max // directions))


def budget(
    *,
    rays: int,
    closest_m: float,
    range_sigma_m: float,
    heading_error_rad: float,
    range_m_max: float,
) -> Budget:
    """Add up the errors.

    Args:
        rays: directions of a scan.
        closest_m: least distance of a centre from an obstacle, where the unseen part matters.
        range_sigma_m: standard deviation of the sensor's ranges.
        heading_error_rad: largest heading error of the drive.
        range_m_max: the longest possible order: nothing is known beyond, and a follower goes no further by
            one order.
    """
    return Budget(
        quantisation_m=closest_m * (1.0 - math.cos(math.tau / rays)),
        range_noise_m=NOISE_SIGMAS * range_sigma_m,
        drive_m=HEADING_ERRORS * range_m_max * heading_error_rad,
    )
