"""Headings that are not tried hold no better step."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from agents.navigation import step
from agents.navigation.certificate import Walls, bounds_walls, certified_lengths_m, scan_walls
from agents.navigation.guidance import Map
from agents.navigation.headings import BESIDE_CELLS, NEAR_CELLS, may_cost_less, seen_m
from agents.navigation.scan import View
from protocol.arrays import scan_bearings_rad, unit_vectors, xy
from protocol.frames import Point
from protocol.mission import Bounds
from tests.support.stages.one_step import ORIGIN, look_around, under
from world.geometry.shapes import Circle

BOUNDS = Bounds(x_m_min=-3.0, y_m_min=-3.0, x_m_max=3.0, y_m_max=3.0)
KEPT_M = 0.12  # between the origin and a post: some posts are nearer than a step keeps

posts = st.builds(
    lambda bearing_rad, off_m, radius_m: Circle(
        centre_m=tuple(((off_m + radius_m) * unit_vectors(np.array(bearing_rad))).tolist()), radius_m=radius_m
    ),
    st.floats(-np.pi, np.pi),
    st.floats(KEPT_M, 2.5),
    st.floats(0.05, 0.8),
)
goals = st.builds(Point, x_m=st.floats(-2.7, 2.7), y_m=st.floats(-2.7, 2.7))
directions = st.sampled_from((8, 90, 360, 1440))


@given(st.lists(posts, max_size=7), goals, directions, st.floats(0.0, 1.0))
def test_no_certified_step_costs_less_on_a_heading_that_is_not_tried(
    shapes: list[Circle], goal: Point, directions: int, share: float
) -> None:
    mission = under(
        "certified", robot_radius_m=0.1, bounds=BOUNDS, goal=goal, directions=directions, range_m_max=2.5
    )
    view = look_around(shapes, mission)
    walls = Walls.joined(scan_walls(view, mission), bounds_walls(BOUNDS, mission))
    known = Map(mission, xy(ORIGIN))
    known.remember(view.hit_points)
    ways = known.cost_to_go(xy(goal), tolerance_m=0.1)
    headings_rad = np.linspace(-np.pi, np.pi, 181)
    lengths_m = np.minimum(certified_lengths_m(view.position, headings_rad, walls), view.ranges_m.max())
    shares = np.linspace(0.0, 1.0, 40)
    ends = unit_vectors(headings_rad)[:, None] * (lengths_m[:, None] * shares)[..., None]
    costs = ways.at(ends.reshape(-1, 2)).reshape(len(headings_rad), -1)
    known_m = float(np.quantile(costs[np.isfinite(costs)], share)) if np.isfinite(costs).any() else np.inf
    is_tried, least_m = may_cost_less(view, headings_rad, ways, known_m)
    assert (costs[~is_tried] > known_m).all()
    assert (costs[lengths_m[:, None] * shares < least_m] > known_m).all()

    with pytest.MonkeyPatch.context() as patch:
        best = step.certified_step_to_goal(view, walls, ways)
        patch.setattr(
            step, "may_cost_less", lambda _, headings, *__: (np.ones(len(headings), dtype=np.bool_), 0.0)
        )
        assert best == step.certified_step_to_goal(view, walls, ways)


def test_behind_a_wall_no_heading_is_tried() -> None:
    mission = under("certified", robot_radius_m=0.1, bounds=BOUNDS, goal=Point(x_m=2.5, y_m=0.0))
    view = look_around([Circle(centre_m=(2.0, 0.0), radius_m=0.5)], mission)
    known = Map(mission, xy(ORIGIN))
    known.remember(view.hit_points)
    ways = known.cost_to_go(xy(Point(x_m=2.5, y_m=0.0)), tolerance_m=0.1)
    headings_rad = np.linspace(-np.pi, np.pi, 361)
    is_tried, _ = may_cost_less(view, headings_rad, ways, 0.3)
    assert not is_tried.any(), "the cells of that cost are hidden"
    is_tried, _ = may_cost_less(view, headings_rad, ways, 2.0)
    assert 0 < is_tried.sum() < len(headings_rad) / 2
    assert (np.abs(headings_rad[is_tried]) < np.pi / 2.0).all(), "the goal is ahead"


@given(directions, st.integers(0), st.floats(-1.0, 1.0))
@example(360, 0, -0.9)  # across the first and the last ray
@example(360, 359, 0.9)
def test_a_long_ray_counts_as_seen_in_all_directions_beside_it_and_in_no_other(
    rays: int, longest: int, share: float
) -> None:
    bearings_rad = scan_bearings_rad(rays)
    ranges_m = np.ones(rays)
    ranges_m[longest % rays] = 3.0
    view = View(np.zeros(2), bearings_rad, ranges_m, np.ones(rays, dtype=np.bool_), 0.0)
    beside_rad = np.arcsin(BESIDE_CELLS / NEAR_CELLS)
    far_rad = beside_rad + 3.0 * 2.0 * np.pi / rays  # the rays to either side, and half a ray
    off_rad = np.array([share * beside_rad, far_rad, -far_rad])
    asked_rad = (bearings_rad[longest % rays] + off_rad + np.pi) % (2.0 * np.pi) - np.pi
    assert seen_m(view, asked_rad).tolist() == [3.0, 1.0, 1.0]
