import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.scan import View, on_discs, on_ground, view
from protocol.arrays import distances_to_segments
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.wire.messages import Scan

RANGE_M_MAX = 4.0
ROUNDING_M = 1e-9

ranges_m = st.lists(st.floats(0.0, 6.0), min_size=8, max_size=16)
tenths = st.integers(-30, 30).map(lambda tenth: tenth / 10.0)
places = st.tuples(tenths, tenths)
clouds = st.lists(places, min_size=1, max_size=12).map(np.array)


def view_of(measured_m: list[float], at: Pose) -> View:
    return view(Scan(t_s=0.0, fence=Fence(), pose=at, ranges_m=tuple(measured_m)), range_m_max=RANGE_M_MAX)


poses = st.builds(Pose, x_m=tenths, y_m=tenths, heading_rad=st.floats(-math.pi, math.pi))


@given(ranges_m, poses)
def test_each_point_lies_at_its_range_and_bearing_in_the_world(measured_m: list[float], at: Pose) -> None:
    seen = view_of(measured_m, at)
    for index, (x_m, y_m) in enumerate(seen.points.tolist()):
        off = complex(x_m - at.x_m, y_m - at.y_m)
        bearing_rad = -math.pi + math.tau * index / len(measured_m)
        ray = min(measured_m[index], RANGE_M_MAX) * complex(math.cos(bearing_rad), math.sin(bearing_rad))
        assert abs(off - ray) <= ROUNDING_M


@given(ranges_m, poses)
def test_a_hit_at_the_range_or_beyond_it_is_not_seen(measured_m: list[float], at: Pose) -> None:
    seen = view_of(measured_m, at)
    assert seen.hits.tolist() == [range_m < RANGE_M_MAX for range_m in measured_m]
    assert seen.ranges_m.max() <= RANGE_M_MAX
    assert len(seen.hit_points) == seen.hits.sum()


@given(ranges_m, poses)
def test_the_nearest_hit_is_the_shortest_range_and_none_where_nothing_is_hit(
    measured_m: list[float], at: Pose
) -> None:
    hits_m = [range_m for range_m in measured_m if range_m < RANGE_M_MAX]
    assert view_of(measured_m, at).nearest_m == min(hits_m, default=None)


def test_the_heading_of_the_body_does_not_turn_the_scan() -> None:
    facing = [view_of([1.0] * 8, Pose(x_m=1.0, y_m=2.0, heading_rad=turn)) for turn in (0.0, 2.0)]
    assert facing[0].points.tolist() == facing[1].points.tolist()


@given(ranges_m, poses, st.data())
def test_removing_directions_removes_exactly_their_hits(
    measured_m: list[float], at: Pose, data: st.DataObject
) -> None:
    seen = view_of(measured_m, at)
    size = len(measured_m)
    away = np.array(data.draw(st.lists(st.booleans(), min_size=size, max_size=size)))
    ground = np.zeros((1, 2, 2))
    left = seen.without(away, ground)
    assert not ground.flags.writeable
    assert len(left.copied().robots) == 0, "a law could make it writable again"
    assert left.hits.tolist() == [bool(hit and not gone) for hit, gone in zip(seen.hits, away, strict=True)]
    assert left.points.tolist() == seen.points.tolist()


@given(clouds, places, places)
def test_distances_to_a_segment_agree_with_shapely(
    cloud: np.ndarray, start: tuple[float, float], end: tuple[float, float]
) -> None:
    measured_m = distances_to_segments(cloud, np.array(start), np.array(end))
    expected_m = shapely.distance(shapely.points(cloud), shapely.LineString([start, end]))
    assert measured_m.tolist() == pytest.approx(expected_m.tolist(), abs=ROUNDING_M)


@given(clouds, st.lists(places, min_size=2, max_size=5), st.floats(0.05, 1.0))
def test_ground_is_the_strip_along_its_polyline(
    cloud: np.ndarray, corners: list[tuple[float, float]], within_m: float
) -> None:
    off_m = shapely.distance(shapely.points(cloud), shapely.LineString(corners))
    on = on_ground(cloud, np.array(corners), within_m=within_m)
    assert on[off_m < within_m - ROUNDING_M].all()
    assert not on[off_m > within_m + ROUNDING_M].any()


@given(clouds, st.lists(places, min_size=1, max_size=4), st.floats(0.05, 1.0))
def test_a_point_is_on_discs_if_it_is_on_one_of_them(
    cloud: np.ndarray, centres: list[tuple[float, float]], within_m: float
) -> None:
    off_m = shapely.distance(shapely.points(cloud), shapely.MultiPoint(centres))
    on = on_discs(cloud, np.array(centres), within_m=within_m)
    assert on[off_m < within_m - ROUNDING_M].all()
    assert not on[off_m > within_m + ROUNDING_M].any()
