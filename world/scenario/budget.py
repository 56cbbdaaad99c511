"""What finite directions, noise and imperfect drives cost.

The certificate pays for what finite directions leave unseen: it keeps that much further from every hit, the
further away it was hit the more. So ray quantisation costs room, in narrow gaps, and next to nothing of the
tolerance: a robot that stands in such a wider keep may drive along it, and what two rays hide may then be a
spacing ahead. Noise and drive errors differ from scan to scan and from drive to drive. mu0 has to cover all.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from world.geometry.shapes import Shape

NOISE_SIGMAS = 3.0
"""Where the sensor clips its Gaussian error: 99.7 % of it lies within."""

HEADING_ERRORS = 3.0
"""Heading errors that add up beside a path: the leader is off its plan, and a follower is off both ends of
the segment that the leader drove."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """The shares of the error budget [m]."""

    quantisation_m: float
    """At the closest approach, beyond what the certificate keeps."""
    range_noise_m: float
    drive_m: float

    @property
    def total_m(self) -> float:
        """What mu0 has to cover."""
        return self.quantisation_m + self.range_noise_m + self.drive_m


def blind_per_range(shapes: Sequence[Shape], directions: int) -> float:
    """How far an obstacle may reach unseen past a ray that hit it, per metre of range.

    Sideways past its last ray: up to the spacing of the rays. A corner of angle gamma that one ray catches
    on its near side, and that the next ray only just misses along its far side, stands out of the joined
    hits by `spacing / sin(gamma)`; a blunt corner by no more than the spacing.
    """
    sharpest_rad = min((shape.sharpest_corner_rad for shape in shapes), default=math.pi / 2)
    return math.tau / directions / math.sin(min(sharpest_rad, math.pi / 2))


def sure_range_m(shapes: Sequence[Shape], directions: int) -> float:
    """The range out to which no obstacle fits between two rays; inf without obstacles."""
    thinnest_m = min((shape.smallest_width_m for shape in shapes), default=math.inf)
    return thinnest_m / (math.tau / directions)


def revolutions(shapes: Sequence[Shape], directions: int, *, wanted_m: float, rays_max: int) -> int:
    """How many interlaced revolutions are sure to show every obstacle out to `wanted_m`, if any are."""
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
        closest_m: how near a centre may come to an obstacle; there the unseen part counts.
        range_sigma_m: of the sensor.
        heading_error_rad: of the drive.
        range_m_max: the longest that a step can be, since nothing is known beyond.
    """
    return Budget(
        quantisation_m=closest_m * (1.0 - math.cos(math.tau / rays)),
        range_noise_m=NOISE_SIGMAS * range_sigma_m,
        drive_m=HEADING_ERRORS * range_m_max * heading_error_rad,
    )
