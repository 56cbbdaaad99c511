"""The error budget: finite directions, sensor noise and drive errors.

The certificate covers what finite directions leave unseen: it keeps a larger distance from each hit, growing
with the range of the hit. So ray quantisation costs room in narrow gaps, and almost nothing of the tolerance
mu0. A small share remains: a robot at that distance may drive along the obstacle, and what two rays hide may
then be one ray spacing ahead. Noise differs between scans, and drive errors between drives. mu0 has to cover
all of these shares.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from protocol.mission import BLIND_PER_RANGE_MAX
from world.geometry.shapes import Shape

NOISE_SIGMAS = 3.0
"""The sensor clips its Gaussian error at so many sigmas: 99.7 % of errors are below."""

HEADING_ERRORS = 3.0
"""Heading errors that add up beside a path: the leader deviates from its plan, and a follower from both ends
of the segment that the leader drove."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Budget:
    """The shares of the error budget [m]."""

    quantisation_m: float
    """At the closest approach, in addition to the distance that the certificate keeps."""
    range_noise_m: float
    drive_m: float

    @property
    def total_m(self) -> float:
        """The sum that mu0 has to cover."""
        return self.quantisation_m + self.range_noise_m + self.drive_m


def blind_per_range(shapes: Sequence[Shape], directions: int) -> float:
    """How far an obstacle can extend unseen past a ray that hit it, per metre of range.

    Sideways past its last ray it extends by up to the ray spacing. At a corner of angle gamma, one ray can
    hit the near side while the next ray just misses along the far side. In the triangle of sensor, hit and
    corner the angle at the hit is then gamma - spacing, so by the law of sines the corner extends beyond the
    hit by `sin(spacing) / sin(gamma - spacing)` of its range; a blunt corner by at most the spacing.
    """
    spacing_rad = math.tau / directions
    sharpest_rad = min((shape.sharpest_corner_rad for shape in shapes), default=math.pi / 2)
    if sharpest_rad >= math.pi / 2:
        return spacing_rad
    if sharpest_rad <= spacing_rad:
        return BLIND_PER_RANGE_MAX
    return min(math.sin(spacing_rad) / math.sin(sharpest_rad - spacing_rad), BLIND_PER_RANGE_MAX)


def sure_range_m(shapes: Sequence[Shape], directions: int) -> float:
    """The range out to which no obstacle fits between two rays; inf without obstacles."""
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
        range_m_max: the longest possible step, since nothing is known beyond.
    """
    return Budget(
        quantisation_m=closest_m * (1.0 - math.cos(math.tau / rays)),
        range_noise_m=NOISE_SIGMAS * range_sigma_m,
        drive_m=HEADING_ERRORS * range_m_max * heading_error_rad,
    )
