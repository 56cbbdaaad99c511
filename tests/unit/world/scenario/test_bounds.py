"""Starts beside the bounds: the strand's path keeps off them, and a start may not be too far from it."""

import math

import pytest
from msgspec.structs import replace

from protocol.frames import Point
from protocol.mission import DRIVE_SHARE, Bounds
from world.scenario.scenario import Scenario, load

GROVE = load("grove", robots=1)
RADIUS_M, MU0_M = GROVE.fleet.robot_radius_m, GROVE.law.mu0_m
DRIVE_M = GROVE.error_budget.drive_m * DRIVE_SHARE
"""What one drive may err."""


def starting(in_m: tuple[float, float], heading_error_rad: float) -> Scenario:
    """The grove with one robot so far from the lower left corner of the bounds, hull to side."""
    assert GROVE.bounds is not None
    place = (GROVE.bounds.x_m_min + RADIUS_M + in_m[0], GROVE.bounds.y_m_min + RADIUS_M + in_m[1], 0.0)
    return replace(
        GROVE,
        fleet=replace(GROVE.fleet, start=None, spacing_m=None, places=(place,)),
        drive=replace(GROVE.drive, heading_error_rad=heading_error_rad),
    )


@pytest.mark.parametrize("in_m", [(0.0, 0.5), (0.5, 0.0)])
def test_a_robot_may_start_at_one_side_of_the_bounds(in_m: tuple[float, float]) -> None:
    starting(in_m, GROVE.drive.heading_error_rad)


def test_in_a_corner_a_robot_may_start_only_if_drives_err_little() -> None:
    room_m = 2.0 * DRIVE_SHARE * MU0_M
    off_m = math.sqrt(2.0) * DRIVE_SHARE * MU0_M
    error_rad = GROVE.drive.heading_error_rad * (room_m - off_m) / DRIVE_M
    starting((0.0, 0.0), 0.99 * error_rad)
    with pytest.raises(ValueError, match="must be within ") as refusal:
        starting((0.0, 0.0), 1.01 * error_rad)
    assert str(refusal.value).endswith("out of the corner of the bounds, got (0.1, 0.1)")


@pytest.mark.parametrize("axis", ["x", "y"])
def test_between_two_sides_of_the_bounds_there_is_room_for_a_path(axis: str) -> None:
    width_m = 2.0 * (RADIUS_M + DRIVE_SHARE * MU0_M)
    fleet = replace(GROVE.fleet, start=None, spacing_m=None, places=((0.0, 0.0, 0.0),))

    def between(room_m: float) -> None:
        sides = {f"{axis}_m_min": -room_m / 2.0, f"{axis}_m_max": room_m / 2.0}
        wide = Bounds(x_m_min=-9.0, y_m_min=-9.0, x_m_max=9.0, y_m_max=9.0)
        replace(GROVE, fleet=fleet, obstacles=(), goal=None, bounds=replace(wide, **sides))

    between(width_m)
    with pytest.raises(ValueError, match=rf"bounds.{axis}_m_min: must be <= {axis}_m_max - 2 "):
        between(0.999 * width_m)


def test_a_paths_bounds_are_met_by_the_shortest_way() -> None:
    laid = GROVE.mission().path_bounds
    assert laid is not None
    inside = Point(x_m=laid.x_m_min + 0.5, y_m=laid.y_m_min + 0.5)
    assert laid.nearest(inside) == inside
    assert laid.nearest(Point(x_m=-9.0, y_m=inside.y_m)) == Point(x_m=laid.x_m_min, y_m=inside.y_m)
    assert laid.nearest(Point(x_m=99.0, y_m=99.0)) == Point(x_m=laid.x_m_max, y_m=laid.y_m_max)
