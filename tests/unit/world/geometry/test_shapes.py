import math

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.support.strategies.shape_strategies import grounds, patiently, points, polygons
from world.geometry import rings
from world.geometry.clearance import clearance
from world.geometry.shapes import Circle, Ellipse, Polygon, Shape, ground_of

SQUARE = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))


def _regular(count: int, radius_m: float) -> Polygon:
    bearings_rad = np.arange(count) * math.tau / count
    ring = radius_m * np.column_stack((np.cos(bearings_rad), np.sin(bearings_rad)))
    return Polygon(vertices_m=tuple((x, y) for x, y in ring.tolist()))


@patiently
@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=3, max_size=7, unique=True))
def test_a_ring_is_simple_exactly_if_shapely_calls_the_polygon_valid(
    vertices: list[tuple[int, int]],
) -> None:
    # Small whole numbers give touching and collinear edges, without rounding.
    sound = shapely.Polygon(vertices).is_valid and shapely.LinearRing(vertices).is_simple
    assert rings.is_simple(np.array(vertices, dtype=np.float64)) == sound


@pytest.mark.parametrize(
    "vertices_m",
    [
        ((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)),  # a bow tie
        ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 0.0), (0.0, 1.0)),  # a corner that touches an edge
        ((0.0, 0.0), (2.0, 0.0), (1.0, 0.0)),  # nothing inside
        ((0.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0)),  # an edge without length
    ],
)
def test_a_ring_that_touches_itself_is_refused(vertices_m: tuple[tuple[float, float], ...]) -> None:
    with pytest.raises(ValueError, match="simple ring"):
        Polygon(vertices_m=vertices_m)


@pytest.mark.parametrize("turn", [1, -1])
def test_corners_are_the_interior_angles_in_either_orientation(turn: int) -> None:
    notched = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 1.0), (0.0, 2.0))[::turn]
    angles = sorted(np.degrees(rings.corners_rad(np.array(notched))).tolist())
    assert angles == pytest.approx([45.0, 45.0, 90.0, 90.0, 270.0])


@patiently
@given(polygons())
def test_interior_angles_add_up(polygon: Polygon) -> None:
    expected_rad = (len(polygon.vertices_m) - 2) * math.pi
    assert rings.corners_rad(polygon.ring_m).sum() == pytest.approx(expected_rad)


@pytest.mark.parametrize(
    ("shape", "width_m"),
    [
        (Circle(centre_m=(1.0, 2.0), radius_m=0.3), 0.6),
        (Ellipse(centre_m=(0.0, 0.0), semi_axes_m=(2.0, 0.3), rotation_rad=1.0), 0.6),
        (Polygon(vertices_m=SQUARE), 1.0),
        (Polygon(vertices_m=((0.0, 0.0), (4.0, 0.0), (0.0, 3.0))), 2.4),  # the least height: 4 * 3 / 5
        # An L with an upright 0.2 m wide, and a U with such a bottom.
        (Polygon(vertices_m=((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.2, 1.0), (0.2, 3.0), (0.0, 3.0))), 0.2),
        (
            Polygon(
                vertices_m=(
                    *((0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (2.0, 2.0)),
                    *((2.0, 0.1), (1.0, 0.1), (1.0, 2.0), (0.0, 2.0)),
                )
            ),
            0.1,
        ),
        # A roof that comes down to 1 m, on either side.
        (Polygon(vertices_m=((0.0, 0.0), (4.0, 0.0), (3.0, 1.0), (1.0, 2.0))), 1.0),
        (Polygon(vertices_m=((0.0, 0.0), (4.0, 0.0), (3.0, 2.0), (1.0, 1.0))), 1.0),
        # A needle with a blunt tip 1 mm wide: no corner is sharp, but the tip can hide between rays.
        (Polygon(vertices_m=((0.0, -0.5), (5.0, -0.0005), (5.0, 0.0005), (0.0, 0.5))), 0.001),
    ],
)
def test_smallest_width_is_that_of_the_thinnest_part(shape: Shape, width_m: float) -> None:
    assert shape.smallest_width_m == pytest.approx(
        width_m, rel=0.02
    )  # perpendicular to the needle's side, not to its axis


@pytest.mark.parametrize("turn", [1, -1])
def test_a_small_ring_far_from_the_origin_is_as_wide_and_as_sharp(turn: int) -> None:
    far = 9e5 + 0.003 * np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 2.0), (0.0, 1.0)])[::turn]
    near = far - far[0]
    assert rings.smallest_width_m(far) == pytest.approx(rings.smallest_width_m(near))
    assert rings.corners_rad(far).sum() == pytest.approx(3.0 * math.pi)


@pytest.mark.parametrize("count", [6, 12, 24, 48])
def test_many_short_edges_do_not_make_a_round_shape_thin(count: int) -> None:
    across_flats_m = 2 * 0.3 * math.cos(math.pi / count)
    assert _regular(count, 0.3).smallest_width_m == pytest.approx(across_flats_m)


def test_an_ellipse_is_as_sharp_as_its_rhombus() -> None:
    assert Ellipse(centre_m=(0.0, 0.0), semi_axes_m=(0.5, 0.5)).sharpest_corner_rad == pytest.approx(
        math.pi / 2
    )
    long = Ellipse(centre_m=(0.0, 0.0), semi_axes_m=(0.1, 1.0))
    assert math.tan(long.sharpest_corner_rad / 2) == pytest.approx(0.1)


@patiently
@given(grounds, points, st.floats(0.0, 3.0), st.floats(0.0, 1.0))
def test_the_ground_near_to_a_place_is_as_near_and_as_solid(
    shapes: list[Shape], at_m: tuple[float, float], side_m: float, reach_m: float
) -> None:
    ground, low = ground_of(shapes), np.array(at_m)
    places = low + side_m * np.indices((3, 3)).reshape(2, -1).T / 2.0
    wanted_m = clearance(ground, places, places)
    near = ground.within(low - reach_m, low + side_m + reach_m)
    apart_m = clearance(near, places, places)
    assert np.where(wanted_m < reach_m, apart_m, 0.0) == pytest.approx(
        np.where(wanted_m < reach_m, wanted_m, 0.0), abs=1e-9
    )
    assert (apart_m[wanted_m >= reach_m] >= reach_m - 1e-9).all()


def test_far_shapes_are_left_out() -> None:
    ground = ground_of([Polygon(vertices_m=SQUARE), Circle(centre_m=(5.0, 0.0), radius_m=1.0)])
    near = ground.within(np.array((-2.0, -1.0)), np.array((-0.6, 1.0)))
    assert (len(near.edges), len(near.circles)) == (0, 0)
    near = ground.within(np.array((3.0, -1.0)), np.array((4.5, 1.0)))
    assert (len(near.edges), near.circle_owner.tolist(), near.shape_count) == (0, [1], 2)


def test_ground_maps_each_row_to_its_shape() -> None:
    circle = Circle(centre_m=(5.0, 5.0), radius_m=0.3)
    ground = ground_of([Polygon(vertices_m=SQUARE), circle, Polygon(vertices_m=SQUARE[::-1])])
    assert ground.shape_count == 3
    assert ground.circle_owner.tolist() == [1]
    assert ground.edge_owner.tolist() == [0] * 4 + [2] * 4
    assert ground.ellipses.shape == (0, 5)


@patiently
@given(polygons(), points)
def test_winding_is_one_inside_and_zero_outside(polygon: Polygon, point: tuple[float, float]) -> None:
    area = shapely.Polygon(polygon.vertices_m)
    assume(not area.boundary.dwithin(shapely.Point(point), 1e-9))
    turns = rings.winding(ground_of([polygon]).edges, np.array([point]))[2]
    assert turns.sum() == float(area.contains(shapely.Point(point)))


@pytest.mark.parametrize(
    ("raw", "complaint"),
    [
        ({"shape": "circle", "centre_m": [0.0, 0.0], "radius_m": 0.0}, "radius_m"),
        ({"shape": "circle", "centre_m": [0.0, 0.0], "radius_m": math.nan}, "radius_m"),
        ({"shape": "ellipse", "centre_m": [0.0, 0.0], "semi_axes_m": [1.0, -1.0]}, "semi_axes_m"),
        ({"shape": "polygon", "vertices_m": [[0.0, 0.0], [1.0, 0.0]]}, "vertices_m"),
        ({"shape": "square", "side_m": 1.0}, "shape"),
        ({"shape": "circle", "centre_m": [0.0, 0.0], "radius_m": 1.0, "colour": "red"}, "colour"),
    ],
)
def test_an_invalid_shape_is_refused(raw: dict[str, object], complaint: str) -> None:
    with pytest.raises(msgspec.ValidationError, match=complaint):
        msgspec.convert(raw, Shape)
