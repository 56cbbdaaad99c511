"""Grants on winding paths, judged by shapely."""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from protocol.frames import Point
from protocol.path import Path
from protocol.sweep import TOUCHING_M, travel_m
from protocol.wire.authority import authority_m
from tests.support.strategies.path_strategies import paths

ROUNDING_M = 1e-9  # of sums of arc lengths, in addition to the touching tolerance
FURTHER_M = 1e-6
GRAZING_M = (
    5e-5  # sqrt(2 * 0.6 * 1e-9): where a path only grazes, so much of it depends on the touching tolerance
)
SAMPLE_M = 0.02


@dataclass(frozen=True)
class Granter:
    """A granter: its path and progress, the tail's progress, and the distance to keep."""

    path: Path
    tail_m: float
    progress_m: float
    keep_m: float

    def grants_m(self) -> float:
        return authority_m(self.path, from_m=self.tail_m, progress_m=self.progress_m, keep_m=self.keep_m)

    def ground(self) -> shapely.LineString:
        """The ground that the granter occupies or will occupy."""
        return shapely.LineString(self.path.between(self.progress_m, self.path.end_m))

    def granted(self, to_m: float) -> shapely.LineString:
        """The path from the tail to the grant."""
        return shapely.LineString(self.path.between(self.tail_m, to_m))


@st.composite
def granters(draw: st.DrawFn) -> Granter:
    path = draw(paths())
    tail_m, progress_m = sorted(draw(st.tuples(st.floats(0.0, 0.5), st.floats(0.0, 1.0))))
    keep_m = draw(st.integers(5, 60)) / 100.0
    return Granter(path, tail_m * path.end_m, progress_m * path.end_m, keep_m)


def along(points: list[tuple[float, float]]) -> Path:
    return Path(Point(x_m=x_m, y_m=y_m) for x_m, y_m in points)


@given(granters())
def test_a_grant_keeps_its_distance_from_all_ground_of_the_granter(granter: Granter) -> None:
    granted_m = granter.grants_m()
    assume(granted_m > granter.tail_m)
    least_m = granter.keep_m - TOUCHING_M - ROUNDING_M
    assert granter.granted(granted_m).distance(granter.ground()) >= least_m
    samples = int((granted_m - granter.tail_m) / SAMPLE_M) + 2
    for s_m in np.linspace(granter.tail_m, granted_m, samples):
        at = granter.path.at(s_m)
        assert granter.ground().distance(shapely.Point(at.x_m, at.y_m)) >= least_m


@given(granters())
def test_a_grant_is_as_long_as_possible(granter: Granter) -> None:
    granted_m = granter.grants_m()
    more = granter.granted(granted_m + FURTHER_M)
    assert more.distance(granter.ground()) <= granter.keep_m + ROUNDING_M


@given(st.floats(0.0, 2.0 * math.pi), st.floats(0.1, 0.6))
def test_a_second_look_grants_no_more_where_the_path_touches_the_granters_ground(
    bearing_rad: float, keep_m: float
) -> None:
    c, s = math.cos(bearing_rad), math.sin(bearing_rad)
    corners = [(-2.0, 0.0), (1.0, 0.0), (1.0, keep_m + 1.0), (0.0, keep_m + 0.6), (0.0, keep_m)]
    path = along([(c * x_m - s * y_m, s * x_m + c * y_m) for x_m, y_m in corners])
    first = Granter(path, 0.0, path.end_m - 0.5, keep_m)
    granted_m = first.grants_m()
    assert granted_m > 3.0, "it ends on the way back, not where the path touches the ground"
    assert replace(first, tail_m=granted_m).grants_m() == pytest.approx(granted_m, abs=FURTHER_M)


@given(granters())
def test_a_grant_lies_between_the_tail_and_the_granter(granter: Granter) -> None:
    assert granter.tail_m <= granter.grants_m() <= granter.progress_m + ROUNDING_M


@given(
    granters(), st.floats(-math.pi, math.pi), st.floats(0.0, 2.0), st.floats(0.0, 1.0), st.floats(0.0, 1.0)
)
def test_a_path_that_grows_away_from_granted_ground_never_reduces_the_grant(
    granter: Granter, bearing_rad: float, stride_m: float, tail: float, driven: float
) -> None:
    granted_m = granter.grants_m()
    assume(granted_m > granter.tail_m)
    _grow(granter, granted_m, bearing_rad, stride_m)
    later = Granter(
        granter.path,
        granter.tail_m + tail * (granted_m - granter.tail_m),
        granter.progress_m + driven * (granter.path.end_m - granter.progress_m),
        granter.keep_m,
    )
    assert later.grants_m() >= granted_m - GRAZING_M


def _grow(granter: Granter, granted_m: float, bearing_rad: float, stride_m: float) -> None:
    """Rule 4: a step that keeps off granted ground, with a margin for rounding."""
    heading = np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
    corners = granter.path.between(granter.tail_m, granted_m)
    keep_m = np.full(len(corners) - 1, granter.keep_m + FURTHER_M)
    end = granter.path.at(granter.path.end_m)
    origin = np.array([end.x_m, end.y_m])
    free_m = float(travel_m(origin, heading[None, :], corners[:-1], corners[1:], keep_m)[0])
    x_m, y_m = origin + min(free_m, stride_m) * heading
    granter.path.extend(Point(x_m=x_m, y_m=y_m))


def test_on_a_straight_path_the_grant_is_the_distance_short_of_the_granter() -> None:
    path = along([(0.0, 0.0), (2.0, 0.0), (5.0, 0.0)])
    assert Granter(path, 0.0, 3.0, 0.4).grants_m() == pytest.approx(2.6)


def test_ground_that_the_granter_will_drive_on_counts_as_its_own() -> None:
    hairpin = along([(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (2.0, 1.0)])
    apart_m = 0.8
    assert Granter(hairpin, 0.0, 5.0, apart_m).grants_m() == pytest.approx(4.0 + 1.0 - apart_m)
    returning = along([(0.0, 0.0), (4.0, 0.0), (4.0, 0.5), (2.0, 0.5)])
    assert Granter(returning, 0.0, 4.5, apart_m).grants_m() == pytest.approx(2.0 - math.sqrt(0.8**2 - 0.5**2))


def test_a_hairpin_with_arms_just_far_enough_apart_does_not_limit_the_grant() -> None:
    hairpin = along([(0.0, 0.0), (4.0, 0.0), (4.0, 0.6), (0.0, 0.6)])
    assert Granter(hairpin, 0.0, 4.6, 0.6).grants_m() == pytest.approx(4.0)


def test_a_path_that_crosses_itself_is_granted_up_to_before_the_crossing() -> None:
    loop = along([(0.0, 0.0), (4.0, 0.0), (4.0, 2.0), (2.0, 2.0), (2.0, -2.0)])
    assert Granter(loop, 0.0, 8.0, 0.5).grants_m() == pytest.approx(1.5)
    assert Granter(loop, 0.0, loop.end_m, 0.5).grants_m() > 4.0


def test_a_granter_that_stands_on_the_tail_grants_nothing() -> None:
    path = along([(0.0, 0.0), (3.0, 0.0)])
    assert Granter(path, 1.0, 1.0, 0.4).grants_m() == 1.0
    assert Granter(path, 0.9, 1.0, 0.4).grants_m() == pytest.approx(0.9)


def test_a_tail_beyond_the_granters_own_place_changes_nothing() -> None:
    path = along([(0.0, 0.0), (3.0, 0.0)])
    assert Granter(path, 2.0, 1.0, 0.4).grants_m() == 1.0
