import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon
from shapely.ops import unary_union

from protocol.mission import Bounds
from protocol.timeline import PromiseBroken
from tests.support.scenes.world_scenarios import scenario
from world.geometry.clearance import clearance, separations
from world.geometry.movers import Movers
from world.geometry.moving import MovingCircle
from world.judge.monitor import Monitor, Promises
from world.judge.moves import Intervals

quietly = settings(deadline=None)  # the machine may be busy
places = st.lists(st.tuples(st.floats(-3, 5), st.floats(-2, 2)), min_size=3, max_size=3)
GROUND = scenario().ground
NOTHING_MOVES = Movers.of(())
OBSTACLES = unary_union(
    [Point(1.5, 0.6).buffer(0.3, quad_segs=256), Polygon([(2, -1.5), (3, -1.5), (3, -0.5), (2, -0.5)])]
)


def monitor(
    *,
    radius_m: float = 0.1,
    clearance_m: float = 0.08,
    separation_m: float = 0.08,
    bounds: Bounds | None = None,
    movers: Movers = NOTHING_MOVES,
) -> Monitor:
    promises = Promises(
        radius_m=radius_m,
        clearance_m_required=clearance_m,
        separation_m_required=separation_m,
        bounds=bounds,
    )
    return Monitor(GROUND, movers, promises)


def play(watcher: Monitor, *instants: list[tuple[float, float]]) -> list[PromiseBroken]:
    """Move all bodies from instant to instant, one second each."""
    broken = watcher.watch(np.array(instants[0]), np.array(instants[0]), t_s=0.0)
    for t_s, (before, after) in enumerate(pairwise(instants), start=1):
        broken += watcher.watch(np.array(before), np.array(after), t_s=float(t_s))
    return broken


@quietly
@given(places, places)
def test_clearance_is_the_least_along_the_whole_move(
    starts: list[tuple[float, float]], ends: list[tuple[float, float]]
) -> None:
    watcher = monitor()
    play(watcher, starts, ends)
    expected_m = [
        LineString([start, end]).distance(OBSTACLES) for start, end in zip(starts, ends, strict=True)
    ]
    # The reference's circle is a polygon of 1024 edges: 1.4e-6 of its radius too small.
    assert watcher.least_clearance.distance_m == pytest.approx(min(expected_m) - 0.1, abs=1e-5)


@quietly
@given(places, places)
def test_separation_is_the_least_at_any_moment_of_the_move(
    starts: list[tuple[float, float]], ends: list[tuple[float, float]]
) -> None:
    watcher = monitor()
    play(watcher, starts, ends)
    shares = np.linspace(0.0, 1.0, 2001)[:, None, None]
    moments = (1 - shares) * np.array(starts) + shares * np.array(ends)
    apart_m = np.hypot(*np.moveaxis(moments[:, :, None] - moments[:, None, :], 3, 0))
    sampled_m = apart_m[:, *np.triu_indices(3, k=1)].min() - 0.2
    # Between two samples a pair comes nearer by at most half of its motion in that time: 16 m / 2000 / 2.
    assert sampled_m - 0.004 <= watcher.least_separation.distance_m <= sampled_m + 1e-9


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 1000))
def test_no_near_pair_is_overlooked_though_not_all_pairs_are_compared_each_time(seed: int) -> None:
    chance = np.random.default_rng(seed)
    places_m, watcher, least_m = chance.uniform(-6, 6, (12, 2)), monitor(radius_m=0.0), math.inf
    courses = chance.uniform(-0.05, 0.05, (12, 2))
    for tick in range(200):
        ends_m = places_m + courses
        watcher.watch(places_m, ends_m, t_s=float(tick))
        least_m = min(least_m, separations(places_m, ends_m).min())
        assert watcher.least_separation.distance_m == pytest.approx(least_m)
        places_m = ends_m


@quietly
@given(
    st.lists(places, min_size=3, max_size=6),
    st.sampled_from([0.0, 0.08]),
    st.sampled_from([2.0, 6.0]),
    st.booleans(),
)
@example([[(x_m, 0.1), (-3.0, -2.0), (5.0, 2.0)] for x_m in (-1.5, -1.5, -1.4, -1.4, 0.9)], 0.0, 6.0, True)
def test_many_intervals_are_judged_at_once_as_one_by_one(
    instants: list[list[tuple[float, float]]], required_m: float, size_m: float, is_crossed: bool
) -> None:
    bounds = Bounds(x_m_min=-size_m, y_m_min=-size_m, x_m_max=size_m, y_m_max=size_m)
    each, many = (
        monitor(
            radius_m=0.01,
            clearance_m=required_m,
            separation_m=required_m,
            bounds=bounds,
            movers=Movers.of((walker((1.0, -2.0, 0.0), (5.0, 2.0, 0.0)),)) if is_crossed else NOTHING_MOVES,
        )
        for _ in range(2)
    )
    at_m = np.array([instants[0], *instants, *instants[-1:]])
    broken = [
        (float(t_s), breach)
        for t_s, (before_m, after_m) in enumerate(pairwise(at_m))
        for breach in each.watch(before_m, after_m, t_s=float(t_s))
    ]
    found: list[tuple[float, PromiseBroken]] = []
    for first, last in ((0, 1), (1, len(at_m) - 1)):
        starts_m, ends_m = at_m[first:last], at_m[first + 1 : last + 1]
        clear_m = np.array([clearance(GROUND, *way) for way in zip(starts_m, ends_m, strict=True)])
        times_s = [float(t_s) for t_s in range(first, last)]
        found += many.watch_all(Intervals(times_s, starts_m, ends_m, clear_m))
    assert found == broken
    assert many.least_clearance == each.least_clearance
    assert many.least_separation == each.least_separation
    assert many.least_moving_clearance == each.least_moving_clearance
    assert many.clearance_m.tolist() == each.clearance_m.tolist()


def test_clearance_is_judged_between_the_ends_of_a_move() -> None:
    broken = play(monitor(), [(0.5, 0.6), (-3.0, 0.0)], [(2.5, 0.6), (-3.0, 0.0)])
    assert [(each.invariant, each.robot) for each in broken] == [("S1", 1)]
    assert broken[0].measured_m == pytest.approx(-0.1)


def test_two_robots_that_swap_places_collide_on_the_way() -> None:
    broken = play(monitor(), [(-2.0, 0.0), (-1.0, 0.0)], [(-1.0, 0.0), (-2.0, 0.0)])
    assert [(each.invariant, each.robot, each.other) for each in broken] == [("S2", 1, 2)]
    assert broken[0].measured_m == pytest.approx(-0.2)


def test_robots_that_follow_at_a_distance_keep_their_promises() -> None:
    watcher = monitor()
    assert play(watcher, [(-1.0, 0.0), (-1.3, 0.0)], [(0.0, 0.0), (-0.3, 0.0)]) == []
    assert watcher.least_separation.distance_m == pytest.approx(0.1)
    assert (watcher.least_separation.robot, watcher.least_separation.other) == (1, 2)


def test_a_promise_that_stays_broken_is_one_violation_until_it_is_kept_again() -> None:
    near, nearer, away = [(1.05, 0.6)], [(1.07, 0.6)], [(0.5, 0.6)]
    assert len(play(monitor(), away, near, nearer, near)) == 1
    assert len(play(monitor(), away, near, away, away, near)) == 2  # the way back is near too


def test_leaving_the_bounds_is_a_violation_of_clearance() -> None:
    bounds = Bounds(x_m_min=-1.0, y_m_min=-1.0, x_m_max=1.0, y_m_max=1.0)
    broken = play(monitor(bounds=bounds), [(-0.5, 0.0)], [(-0.9, 0.0)], [(-0.95, 0.0)])
    assert [(each.invariant, each.why) for each in broken] == [("S1", "out of bounds")]
    assert broken[0].measured_m == pytest.approx(-0.05)


@pytest.mark.parametrize(("gap_m", "violations"), [(0.001, 0), (0.0, 1), (-0.001, 1)])
def test_a_law_that_promises_nothing_is_judged_by_contact(gap_m: float, violations: int) -> None:
    points = monitor(radius_m=0.0, clearance_m=0.0, separation_m=0.0)
    broken = play(points, [(1.0, -1.0)], [(2.0 - gap_m, -1.0)])
    assert [each.why for each in broken] == ["touched an obstacle"] * violations


def test_two_robots_of_a_law_that_promises_nothing_touch() -> None:
    points = monitor(radius_m=0.0, clearance_m=0.0, separation_m=0.0)
    (broken,) = play(points, [(-2.0, 0.0), (-1.0, 0.0)], [(-1.0, 0.0), (-2.0, 0.0)])
    assert (broken.invariant, broken.why) == ("S2", "two robots touched")


def test_robots_of_radius_zero_are_separated_by_their_centres() -> None:
    points = monitor(radius_m=0.0, clearance_m=0.0, separation_m=0.04)
    assert play(points, [(0.0, 0.0), (-0.05, 0.0)]) == []
    assert [
        each.invariant for each in play(points, [(0.0, 0.0), (-0.03, 0.0)], [(0.1, 0.0), (0.07, 0.0)])
    ] == ["S2"]


def walker(*track: tuple[float, float, float], name: str = "walker") -> MovingCircle:
    return MovingCircle(id=name, radius_m=0.2, track=track)


def contacts(broken: list[PromiseBroken]) -> list[tuple[str, int, str]]:
    return [(each.invariant, each.robot, each.why) for each in broken]


MET = ("S1", 1, "in contact with moving obstacle walker while it moved")
CROSSES = Movers.of((walker((0.0, -2.0, -1.0), (2.0, -2.0, 1.0)),))  # it is at (-2, 0) after a second


def test_a_robot_that_drives_into_a_moving_obstacle_breaks_its_promise_and_names_it() -> None:
    watcher = monitor(movers=CROSSES)
    assert contacts(play(watcher, [(-3.0, 0.0)], [(-2.0, 0.0)])) == [MET]
    assert watcher.least_moving_clearance.distance_m == pytest.approx(-0.1)
    assert (watcher.least_moving_clearance.robot, watcher.least_moving_clearance.t_s) == (1, 1.0)


def test_a_robot_that_stands_may_be_touched_and_is_not_measured() -> None:
    watcher = monitor(movers=CROSSES)
    assert play(watcher, [(-2.0, 0.0)], [(-2.0, 0.0)], [(-2.0, 0.0)]) == []
    assert watcher.least_moving_clearance.distance_m == math.inf


def test_the_robots_that_stand_while_another_moves_may_be_touched() -> None:
    watcher = monitor(movers=CROSSES)
    assert play(watcher, [(-2.0, 0.0), (-3.0, 0.0)], [(-2.0, 0.0), (-3.5, 0.0)]) == []
    assert watcher.least_moving_clearance.robot == 2


def test_a_robot_that_drives_off_from_under_an_obstacle_was_in_contact_while_it_moved() -> None:
    watcher = monitor(movers=CROSSES)
    assert contacts(play(watcher, [(-2.0, 0.0)], [(-2.0, 0.0)], [(-3.0, 0.0)])) == [MET]


def test_contact_between_the_ends_of_two_moves_is_found() -> None:
    head_on = Movers.of((walker((0.0, 0.0, -1.0), (1.0, -3.0, -1.0)),))
    assert contacts(play(monitor(movers=head_on), [(-3.0, -1.0)], [(0.0, -1.0)])) == [MET]


def test_contact_with_an_obstacle_that_turns_during_a_move_is_found() -> None:
    there_and_back = Movers.of((walker((0.0, -2.0, -1.0), (0.5, -2.0, 0.0), (1.0, -2.0, -1.0)),))
    watcher = monitor(movers=there_and_back)
    assert contacts(play(watcher, [(-2.5, 0.0)], [(-1.5, 0.0)])) == [MET]


def test_passing_close_to_a_moving_obstacle_is_no_violation() -> None:
    beside = Movers.of((walker((0.0, -3.0, 0.301), (1.0, 0.0, 0.301)),))
    watcher = monitor(movers=beside)
    assert play(watcher, [(-3.0, 0.0)], [(0.0, 0.0)]) == []
    assert watcher.least_moving_clearance.distance_m == pytest.approx(0.001)
    assert watcher.least_clearance.distance_m > 1.0  # only of static obstacles


def test_lasting_contact_is_one_violation_per_obstacle() -> None:
    two = Movers.of(tuple(walker((0.0, x_m, 0.0), name=f"{x_m}") for x_m in (-2.0, -1.5)))
    through = [[(-3.0 + 0.25 * k, 0.0)] for k in range(13)]
    whys = [why for _, _, why in contacts(play(monitor(movers=two), *through))]
    assert whys == [f"in contact with moving obstacle {name} while it moved" for name in ("-2.0", "-1.5")]


def test_a_thousand_bodies_are_watched_in_one_expression() -> None:
    grid = np.array([(-3.9 + 0.3 * (k % 100), -40.0 - 0.3 * (k // 100)) for k in range(1000)])
    watcher = monitor()
    assert watcher.watch(grid, grid + 0.01, t_s=0.02) == []
    assert watcher.least_separation.distance_m == pytest.approx(0.1)
    assert math.isfinite(watcher.least_clearance.distance_m)
