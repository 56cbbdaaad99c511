"""Straight motion past segments, judged by shapely. Lengths in the strategies are on a grid of millimetres,
so that parallel, grazing and degenerate cases are frequent."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from protocol.arrays import Floats, distances_to_segments, nearest_on_segments
from protocol.sweep import TOUCHING_M, Stadiums, cut_where_near, distance_m, free_way_m, travel_m

HORIZON_M = 20.0  # nothing here is further apart
ROUNDING_M = 1e-12  # of sums of metres
FURTHER_M = 1e-6

millimetres = st.integers(-3000, 3000).map(lambda mm: mm / 1000.0)
points = st.tuples(millimetres, millimetres).map(np.array)
segments = st.tuples(points, points)
keeps_m = st.integers(50, 800).map(lambda mm: mm / 1000.0)
bearings = st.one_of(st.floats(-math.pi, math.pi), st.integers(0, 7).map(lambda eighth: eighth * math.pi / 4))


@dataclass(frozen=True)
class Motion:
    """A start, a heading, and segments in the way."""

    origin: Floats
    heading: Floats
    starts: Floats
    ends: Floats
    keep_m: Floats

    def free_m(self) -> float:
        free = travel_m(self.origin, self.heading[None, :], self.starts, self.ends, self.keep_m)
        return min(float(free[0]), HORIZON_M)

    def distances_m(self, length_m: float) -> Floats:
        """The least distance of the whole motion from each segment, by shapely."""
        driven = shapely.LineString([self.origin, self.origin + length_m * self.heading])
        lines = shapely.linestrings(np.stack([self.starts, self.ends], axis=1))
        return np.asarray(shapely.distance(lines, driven))

    def only(self, which: np.ndarray) -> "Motion":
        return Motion(self.origin, self.heading, self.starts[which], self.ends[which], self.keep_m[which])


def _heading(bearing_rad: float) -> Floats:
    return np.array([math.cos(bearing_rad), math.sin(bearing_rad)])


@st.composite
def motions(draw: st.DrawFn) -> Motion:
    walls = draw(st.lists(segments, min_size=1, max_size=5))
    keep_m = np.array([draw(keeps_m) for _ in walls])
    starts, ends = (np.array(side) for side in zip(*walls, strict=True))
    return Motion(draw(points), _heading(draw(bearings)), starts, ends, keep_m)


LAST_BITS_M = st.sampled_from([0.0, 1e-16, -1e-16, 1e-10, -1e-10, 1e-9, -1e-9, -2e-9])


@st.composite
def motions_beside(draw: st.DrawFn, beyond_keep_m: st.SearchStrategy[float]) -> Motion:
    """One segment, and a start beside it, further away than the distance to keep by so much."""
    start, keep_m = draw(points), draw(keeps_m)
    unit, length_m = _heading(draw(bearings)), draw(st.floats(0.01, 6.0))
    normal = np.array([-unit[1], unit[0]])
    origin = start + draw(st.floats(0.0, length_m)) * unit + (keep_m + draw(beyond_keep_m)) * normal
    heading = draw(st.one_of(bearings.map(_heading), st.just(-normal), st.just(unit)))
    return Motion(origin, heading, start[None, :], (start + length_m * unit)[None, :], np.array([keep_m]))


touching_motions = motions_beside(LAST_BITS_M)


@given(st.one_of(motions(), touching_motions))
def test_driving_the_free_distance_keeps_every_distance_or_comes_no_nearer(motion: Motion) -> None:
    at_first_m = motion.distances_m(0.0)
    assume(bool((at_first_m > 0.01).all()))
    free_m = motion.free_m()
    # A start inside may leave with a heading that is off by the touching tolerance.
    allowance_m = TOUCHING_M * np.maximum(1.0, free_m / at_first_m) + ROUNDING_M
    floor_m = np.minimum(motion.keep_m, at_first_m) - allowance_m
    assert (motion.distances_m(free_m) >= floor_m).all()


@given(st.one_of(motions(), touching_motions))
def test_driving_further_than_the_free_distance_comes_too_near(motion: Motion) -> None:
    free_m = motion.free_m()
    assume(free_m < HORIZON_M)
    further_m = motion.distances_m(free_m + FURTHER_M)
    limit_m = np.minimum(motion.keep_m + ROUNDING_M, motion.distances_m(0.0))
    assert (further_m <= limit_m).any()


@given(motions())
def test_a_segment_behind_the_motion_is_not_in_the_way(motion: Motion) -> None:
    nearest = nearest_on_segments(motion.origin, motion.starts, motion.ends) - motion.origin
    too_near = np.hypot(*nearest.T) < motion.keep_m
    receding = nearest @ motion.heading < 0.0
    assert motion.free_m() == motion.only(~(too_near & receding)).free_m()


@given(motions_beside(st.floats(-0.04, -1e-8)))
def test_a_segment_that_is_too_near_forbids_only_motion_towards_it(motion: Motion) -> None:
    nearest = nearest_on_segments(motion.origin, motion.starts, motion.ends) - motion.origin
    towards = float(nearest[0] @ motion.heading)
    assume(abs(towards) > 2.0 * TOUCHING_M)
    assert (motion.free_m() == 0.0) == (towards > 0.0)


@given(motions_beside(st.floats(-0.04, -1e-6)), st.floats(0.001, 0.1))
def test_where_drives_err_it_forbids_all_motion_that_may_lead_towards_it(
    motion: Motion, error_rad: float
) -> None:
    nearest = (nearest_on_segments(motion.origin, motion.starts, motion.ends) - motion.origin)[0]
    off_m = math.hypot(*nearest)
    assume(off_m > 0.001)
    leads_off_rad = math.asin(max(-1.0, min(1.0, -float(nearest @ motion.heading) / off_m)))
    assume(abs(leads_off_rad - error_rad) > 1e-5)
    wall = Stadiums(motion.origin, motion.starts, motion.ends, motion.keep_m, away=math.sin(error_rad))
    assert (wall.travel_m(motion.heading[None, :])[0] == 0.0) == (leads_off_rad < error_rad)


@pytest.mark.parametrize("off_m", [0.0, 5e-17, -5e-17, 1e-10, -1e-10, 1e-9, -1e-9])
def test_a_start_that_touches_a_wall_exactly_cannot_pass_through_it(off_m: float) -> None:
    wall = np.array([[-5.0, 0.0]]), np.array([[5.0, 0.0]])
    free = travel_m(np.array([0.0, -0.3 + off_m]), _heading(math.pi / 2)[None, :], *wall, np.array([0.3]))
    assert free[0] <= 3.0 * TOUCHING_M


@pytest.mark.parametrize("off_m", [0.0, 5e-17, -5e-17, -5e-10])
def test_a_start_that_touches_a_wall_can_move_along_it(off_m: float) -> None:
    wall = np.array([[-5.0, 0.0]]), np.array([[5.0, 0.0]])
    free = travel_m(np.array([0.0, -0.3 + off_m]), np.array([[1.0, 0.0]]), *wall, np.array([0.3]))
    assert free[0] == math.inf


@pytest.mark.parametrize("closing", [5e-324, 1e-17, -1e-17])
def test_rounding_of_a_heading_along_a_wall_does_not_block_it(closing: float) -> None:
    wall = np.array([[-5.0, 0.0]]), np.array([[5.0, 0.0]])
    for off_m in (0.3, 0.4):
        free = travel_m(np.array([0.0, -off_m]), np.array([[1.0, closing]]), *wall, np.array([0.3]))
        assert free[0] == math.inf


@given(motions(), st.floats(0.001, 5.0))
def test_free_way_m_equals_travel_m_for_one_heading(motion: Motion, length_m: float) -> None:
    target, keep_m = motion.origin + length_m * motion.heading, float(motion.keep_m[0])
    x, y = target - motion.origin
    line = np.stack([motion.starts, motion.ends], axis=1).reshape(-1, 2)
    free = travel_m(
        motion.origin,
        np.array([(x, y)]) / math.hypot(x, y),
        line[:-1],
        line[1:],
        np.full(len(line) - 1, keep_m),
    )
    places = [(corner[0], corner[1]) for corner in line.tolist()]
    along = free_way_m(tuple(motion.origin.tolist()), tuple(target.tolist()), places, keep_m)
    assert along == pytest.approx(min(float(free[0]), length_m), abs=ROUNDING_M)
    off = nearest_on_segments(motion.origin, line[:-1], line[1:]) - motion.origin
    assert distance_m(tuple(motion.origin.tolist()), places) == pytest.approx(
        np.hypot(*off.T).min(), abs=ROUNDING_M
    )


@given(motions())
def test_all_headings_together_give_the_same_result_as_each_alone(motion: Motion) -> None:
    headings = np.stack([motion.heading, -motion.heading, motion.heading[::-1]])
    wall = motion.starts, motion.ends, motion.keep_m
    each = [travel_m(motion.origin, heading[None, :], *wall)[0] for heading in headings]
    assert travel_m(motion.origin, headings, *wall).tolist() == pytest.approx(each, abs=ROUNDING_M)


@pytest.mark.parametrize("turn_rad", np.linspace(-math.pi, math.pi, 25))
@pytest.mark.parametrize("aim_rad", [-0.6, -0.2, 0.0, 0.2, 0.6])
def test_a_segment_in_the_way_is_found_at_any_position(turn_rad: float, aim_rad: float) -> None:
    start, end = 2.0 * _heading(turn_rad - 0.5), 2.5 * _heading(turn_rad + 0.5)
    unturned = 2.0 * _heading(-0.5), 2.5 * _heading(0.5)
    free, there = (
        travel_m(np.zeros(2), _heading(bearing)[None, :], one[None], other[None], np.array([0.4]))[0]
        for bearing, one, other in ((turn_rad + aim_rad, start, end), (aim_rad, *unturned))
    )
    assert there < 3.0
    assert free == pytest.approx(there, abs=ROUNDING_M)


def test_without_segments_the_free_distance_is_infinite() -> None:
    none = np.empty((0, 2))
    assert travel_m(np.zeros(2), np.array([[1.0, 0.0]]), none, none, np.empty(0)).tolist() == [math.inf]


@given(points, st.lists(segments, min_size=1, max_size=4))
def test_the_nearest_point_lies_on_its_segment_and_is_the_nearest(
    point: Floats, walls: list[tuple[Floats, Floats]]
) -> None:
    starts, ends = (np.array(side) for side in zip(*walls, strict=True))
    nearest = nearest_on_segments(point, starts, ends)
    for found, start, end in zip(nearest, starts, ends, strict=True):
        line = shapely.LineString([start, end])
        assert line.distance(shapely.Point(found)) <= ROUNDING_M
        assert np.hypot(*(found - point)) == pytest.approx(
            line.distance(shapely.Point(point)), abs=ROUNDING_M
        )


@given(motions())
def test_cutting_segments_where_they_are_too_near_changes_no_distance(motion: Motion) -> None:
    starts, ends, keep_m = cut_where_near(motion.origin, motion.starts, motion.ends, motion.keep_m)
    uncut = distances_to_segments(motion.origin, motion.starts, motion.ends)
    cut = distances_to_segments(motion.origin, starts, ends)
    assert cut.min() == pytest.approx(uncut.min(), abs=ROUNDING_M)
    lengths_m = [float(np.hypot(*(b - a).T).sum()) for a, b in ((motion.starts, motion.ends), (starts, ends))]
    assert lengths_m[0] == pytest.approx(lengths_m[1], abs=ROUNDING_M)
    assert len(keep_m) == len(starts)


@pytest.mark.parametrize("inside_m", [1e-6, 0.01, 0.1])
def test_beside_a_long_segment_that_is_too_near_no_motion_goes_on_until_it_leads_away(
    inside_m: float,
) -> None:
    """Else the errors of one drive after the other would add up."""
    wall = np.array([[-50.0, 0.0]]), np.array([[50.0, 0.0]]), np.array([0.3])
    origin, keep_m = np.array([0.0, 0.3 - inside_m]), 0.3
    away_rad = math.acos((keep_m - inside_m) / keep_m)  # so steep is the way to where the distance is kept
    headings = np.stack([_heading(turn * away_rad) for turn in (0.0, 0.9, 1.1)])
    free_m = travel_m(origin, headings, *cut_where_near(origin, *wall))
    assert (free_m[:2] < 1e-4).all()
    assert free_m[2] == math.inf
    assert (travel_m(origin, headings, *wall) == math.inf).all(), "uncut, it never comes nearer"
