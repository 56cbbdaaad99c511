from itertools import combinations
from math import dist

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from protocol.mission import Bounds
from world.clearance import distances
from world.deployment import free_places
from world.shapes import Circle, ground_of

BOUNDS = Bounds(x_m_min=0.0, y_m_min=0.0, x_m_max=4.0, y_m_max=3.0)
POST = ground_of([Circle(centre_m=(2.0, 1.5), radius_m=0.8)])


def drawn(robots: int, seed: int, apart_m: float = 0.3) -> list[tuple[float, float]] | None:
    poses = free_places(robots, BOUNDS, POST, seed=seed, hull_m=0.1, clear_m=0.2, apart_m=apart_m)
    return None if poses is None else [(pose.x_m, pose.y_m) for pose in poses]


@given(st.integers(1, 8), st.integers(0, 2**32))
def test_places_are_free_inside_the_bounds_and_apart(robots: int, seed: int) -> None:
    places = drawn(robots, seed)
    assert places is not None
    assert len(places) == robots
    assert all(0.1 <= x_m <= 3.9 and 0.1 <= y_m <= 2.9 for x_m, y_m in places)
    assert all(distances(POST, np.array(place)).min() >= 0.2 for place in places)
    assert all(dist(one, other) >= 0.3 for one, other in combinations(places, 2))


@given(st.integers(0, 2**32))
def test_a_seed_decides_the_places_and_fewer_robots_start_at_the_first_of_them(seed: int) -> None:
    places = drawn(5, seed)
    assert places is not None
    assert drawn(3, seed) == places[:3]
    assert drawn(5, seed + 1) != places


def test_where_there_is_no_room_there_are_no_places() -> None:
    assert drawn(3, 1, apart_m=5.0) is None
