"""Which corners count as ones that a ray can meet."""

import math

import pytest

from world.geometry.shapes import Circle, Polygon, Shape
from world.scenario.corners import sharpest_corner_rad

BLOCK = Polygon(vertices_m=((0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)))


def wedge(tip_x_m: float, degrees: float = 10.0, long_m: float = 1.0) -> Polygon:
    """A triangle whose tip points to the left, in the middle of the block's height."""
    half_m = long_m * math.tan(math.radians(degrees) / 2.0)
    return Polygon(
        vertices_m=((tip_x_m, 1.5), (tip_x_m + long_m, 1.5 - half_m), (tip_x_m + long_m, 1.5 + half_m))
    )


@pytest.mark.parametrize(
    ("shapes", "degrees"),
    [
        ([], 90.0),
        ([BLOCK], 90.0),
        ([BLOCK, wedge(1.0)], 90.0),
        ([wedge(1.0), BLOCK], 90.0),
        ([BLOCK, wedge(-0.01)], 10.0),
        ([BLOCK, wedge(0.0)], 10.0),
        ([BLOCK, wedge(5.0)], 10.0),
        ([BLOCK, wedge(1.0), wedge(5.0, 30.0)], 30.0),
        ([Circle(centre_m=(0.0, 1.5), radius_m=0.5), wedge(0.0, long_m=0.2)], 90.0),
        ([Circle(centre_m=(0.0, 1.5), radius_m=0.5), wedge(0.0)], 85.0),
    ],
    ids=[
        "nothing",
        "a block",
        "hidden in a block",
        "hidden in a block that comes later",
        "its tip sticks out of a block",
        "its tip touches a block's face from inside",
        "it stands free",
        "one hidden and one free",
        "all of it in a circle",
        "its tip in a circle, its other corners bare",
    ],
)
def test_a_corner_counts_unless_it_lies_inside_another_obstacle(shapes: list[Shape], degrees: float) -> None:
    assert sharpest_corner_rad(shapes) == pytest.approx(math.radians(degrees))


def test_a_moving_obstacle_covers_no_corner_and_its_own_corners_always_count() -> None:
    assert sharpest_corner_rad([wedge(1.0)], [BLOCK]) == pytest.approx(math.radians(10.0))
    assert sharpest_corner_rad([BLOCK], [wedge(1.0)]) == pytest.approx(math.radians(10.0))
