"""Whether a strand folds back on itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.coordinating.folding import folds_back, line_of, robots_apart
from protocol.frames import Point, Pose

LEAST_M = 0.25
CORNER = Point(x_m=2.0, y_m=0.0)
HERE, THERE = Point(x_m=0.0, y_m=0.0), Point(x_m=2.0, y_m=2.0)
halves = st.integers(-6, 6).map(lambda half: half / 2.0)
poses = st.builds(Pose, x_m=halves, y_m=halves, heading_rad=st.just(0.0))


def at(x_m: float, y_m: float) -> Pose:
    return Pose(x_m=x_m, y_m=y_m, heading_rad=0.0)


HAIRPIN = {4: at(0.0, 0.0), 3: at(1.0, 0.0), 2: at(1.0, 0.2), 1: at(0.0, 0.2)}


def test_the_way_of_a_strand_leads_over_the_corners_of_its_legs() -> None:
    places = {1: at(2.0, 2.0), 2: at(0.0, 0.0), 3: at(-1.0, 0.0)}
    line, leg = line_of(places, (1, 2, 3), {2: (HERE, CORNER, THERE)})
    assert np.array_equal(line, [(2.0, 2.0), (2.0, 0.0), (0.0, 0.0), (-1.0, 0.0)])
    assert leg.tolist() == [0, 0, 1]


def test_a_hairpin_folds_back_and_a_queue_does_not() -> None:
    assert folds_back(HAIRPIN, (1, 2, 3, 4), {}, least_m=LEAST_M)
    assert not folds_back(
        {robot: at(float(robot), 0.0) for robot in range(1, 9)}, (3, 4, 5), {}, least_m=LEAST_M
    )


def test_a_corner_can_make_a_strand_fold_back_that_is_straight_without_it() -> None:
    places = {1: at(2.0, 0.0), 2: at(1.0, 0.0), 3: at(0.0, 0.0)}
    assert not folds_back(places, (1, 2, 3), {}, least_m=LEAST_M)
    assert folds_back(places, (1, 2, 3), {3: (HERE, Point(x_m=2.0, y_m=0.1), THERE)}, least_m=LEAST_M)


@pytest.mark.parametrize("order", [(), (1,)])
def test_fewer_than_two_robots_do_not_fold_back(order: tuple[int, ...]) -> None:
    assert not folds_back(HAIRPIN, order, {}, least_m=LEAST_M)


@given(st.lists(poses, min_size=2, max_size=7))
def test_as_many_are_apart_as_do_not_fold_back_one_by_one(places: list[Pose]) -> None:
    numbered = dict(enumerate(places, start=1))
    order = tuple(numbered)
    count = robots_apart(numbered, order, {}, least_m=LEAST_M)
    folds = [folds_back(numbered, order[:length], {}, least_m=LEAST_M) for length in range(1, len(order) + 1)]
    assert folds == [length > count for length in range(1, len(order) + 1)]
