"""The second judge finds the least distances over the whole motion, their moments, and who has arrived."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.judges import found, poses, scenario
from tests.support.strategies.examples import examples

POST = {"shape": "circle", "centre_m": [2.0, 0.5], "radius_m": 0.2}
BLOCK = {"shape": "polygon", "vertices_m": [[1.5, 0.3], [2.5, 0.3], [2.5, 0.9], [1.5, 0.9]]}
LENS = {"shape": "ellipse", "centre_m": [2.0, 0.5], "semi_axes_m": [0.4, 0.2], "rotation_rad": math.pi / 2}
THROUGH = poses(1, (0.0, 0.0, 0.0), (4.0, 4.0, 0.0))


@pytest.mark.parametrize(("obstacle", "least_m"), [(POST, 0.2), (BLOCK, 0.2), (LENS, 0.0)])
def test_clearance_is_least_between_two_samples(obstacle: object, least_m: float) -> None:
    least = found(THROUGH, scenario(obstacle=[obstacle])).clearance
    assert least is not None
    assert least.distance_m == pytest.approx(least_m, abs=1e-6)
    assert least.what == "robot 1 and obstacle 1"
    assert least.t_s == pytest.approx(1.5 if obstacle is BLOCK else 2.0, abs=1e-3)


@pytest.mark.parametrize(("clear_m", "broken"), [(0.081, False), (0.08, False), (0.079, True), (0.0, True)])
def test_a_hull_keeps_epsilon_less_mu0(clear_m: float, broken: bool) -> None:
    post = {"shape": "circle", "centre_m": [2.0, 0.1 + clear_m + 0.2], "radius_m": 0.2}
    assert bool(found(THROUGH, scenario(obstacle=[post])).broken) is broken


def test_contact_breaks_a_promise_where_none_is_made() -> None:
    law = {"law": "printed", "epsilon_m": 0.1, "mu0_m": 0.02}
    touching = [*poses(1, (0.0, 0.0, 0.0)), *poses(2, (0.0, 0.2, 0.0))]
    assert (
        found(touching, scenario(law=law)).broken[0].startswith("S2 (separation): robot 1 and robot 2: 0.0")
    )


def test_an_obstacle_that_is_driven_through_is_a_contact() -> None:
    finding = found(poses(1, (0.0, 1.9, 0.4), (1.0, 2.0, 0.5)), scenario(obstacle=[BLOCK]))
    assert finding.clearance is not None
    assert finding.clearance.distance_m == pytest.approx(-0.1)
    assert finding.broken[0].startswith("S1 (clearance): robot 1 and obstacle 1")


def test_two_hulls_that_pass_each_other_between_samples_are_compared_at_the_same_moment() -> None:
    there, back = poses(1, (0.0, 0.0, 0.0), (4.0, 4.0, 0.0)), poses(2, (0.0, 4.0, 0.22), (4.0, 0.0, 0.22))
    least = found([*there, *back]).separation
    assert least is not None
    assert least.distance_m == pytest.approx(0.02)
    assert least.t_s == pytest.approx(2.0)
    assert least.what == "robot 1 and robot 2"
    late = poses(2, (0.0, 4.0, 0.22), (4.0, 4.0, 0.22), (8.0, 0.0, 0.22))
    later = found([*there, *late]).separation
    assert later is not None
    assert later.t_s == pytest.approx(4.0), "the same ways, but at other times"


def test_hulls_that_come_nearer_than_the_separation_less_mu0_break_s2() -> None:
    near = [*poses(1, (0.0, 4.0, 0.0)), *poses(2, (0.0, 4.229, 0.0))]
    assert found(near).broken == (
        "S2 (separation): robot 1 and robot 2: 0.0290 m at t=0.00 s, required 0.0300 m",
    )
    assert not found([*poses(1, (0.0, 4.0, 0.0)), *poses(2, (0.0, 4.231, 0.0))]).broken


MOVER = {"shape": "circle", "id": "cart", "radius_m": 0.3, "track": [[1.0, 2.0, -2.0], [3.0, 2.0, 2.0]]}


def test_a_hull_that_drives_touches_no_moving_obstacle() -> None:
    finding = found(THROUGH, scenario(moving=[MOVER]))
    assert finding.moving_clearance is not None
    assert finding.moving_clearance.distance_m == pytest.approx(-0.1)
    assert finding.moving_clearance.what == "robot 1 and moving obstacle cart"
    assert any(each.startswith("S1 (clearance): robot 1 and moving obstacle cart") for each in finding.broken)


def test_a_hull_that_stands_may_be_touched() -> None:
    stands = poses(1, (0.0, 1.0, 0.0), (1.0, 2.0, 0.0), (4.0, 2.0, 0.0))
    finding = found(stands, scenario(moving=[MOVER]))
    assert finding.moving_clearance is not None
    assert finding.moving_clearance.distance_m == pytest.approx(2.0 - 0.3 - 0.1), "as it was until t = 1 s"


def test_a_moving_polygon_is_where_its_track_says() -> None:
    corners = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]
    box = {
        "shape": "polygon",
        "id": "box",
        "vertices_m": corners,
        "track": [[0.0, 0.0, 1.0], [4.0, 4.0, 1.0]],
    }
    least = found(THROUGH, scenario(moving=[box])).moving_clearance
    assert least is not None
    assert least.distance_m == pytest.approx(0.7)


@pytest.mark.parametrize(("x_m", "out"), [(8.89, False), (8.91, True)])
def test_hulls_stay_inside_the_bounds(x_m: float, out: bool) -> None:
    finding = found(poses(1, (0.0, x_m, 0.0)))
    assert any("out of bounds" in each for each in finding.broken) is out


def test_a_body_that_is_elsewhere_sooner_than_it_can_be_is_found() -> None:
    assert not found(THROUGH).broken
    assert (
        found(poses(1, (0.0, 0.0, 0.0), (4.0, 4.1, 0.0)))
        .broken[0]
        .startswith("S3 (orders): robot 1 jumps 4.1")
    )


KEEP_M = 0.32  # 2 r + epsilon + mu0


def queue(*x_m: float) -> list[dict[str, object]]:
    return [entry for robot, x in enumerate(x_m, start=1) for entry in poses(robot, (9.0, x, 0.0))]


def test_a_fleet_that_stands_in_one_chain_at_the_goal_has_arrived() -> None:
    finding = found(queue(4.0, 4.0 - KEEP_M, 4.0 - 2 * KEEP_M))
    assert finding.ok
    assert finding.chain == (1, 2, 3)


@pytest.mark.parametrize(("short_m", "arrived"), [(0.119, True), (0.121, False), (0.33, False)])
def test_nobody_at_the_goal_is_no_arrival(short_m: float, arrived: bool) -> None:
    finding = found(queue(4.0 - short_m, 4.0 - short_m - KEEP_M))
    assert finding.ok is arrived
    assert finding.goal_m == pytest.approx(short_m)
    assert arrived or finding.missed[0].startswith("nobody stands at the goal")


def test_followers_that_stand_too_far_back_have_not_arrived() -> None:
    second_m = 4.0 - KEEP_M - 0.039  # within 2 mu0
    finding = found(queue(4.0, second_m, second_m - KEEP_M - 0.041, 1.0))
    assert finding.chain == (1, 2)
    assert [each[:7] for each in finding.missed] == ["robot 3", "robot 4"]


@pytest.mark.parametrize(("bend_m", "arrived"), [(0.3, True), (0.2, False)])
def test_on_a_bend_a_robot_stands_as_near_to_the_way_of_those_ahead(bend_m: float, arrived: bool) -> None:
    bend = [(4.0, 1.0), (4.0, KEEP_M), (4.0 - bend_m, KEEP_M), (4.0 - bend_m, 0.0), (4.0, 0.0)]
    leads = poses(1, *((2.0 * t_s, *at) for t_s, at in enumerate(bend)))
    follows = poses(2, (0.0, 4.0, 1.0 + KEEP_M), (9.0, 4.0, KEEP_M))
    last = poses(
        3, (0.0, 3.4, 1.0), (9.0, 3.4, KEEP_M / 2.0)
    )  # 0.30 m from the bend, 0.62 m from both robots
    finding = found([*leads, *follows, *last])
    assert finding.ok is arrived
    assert finding.chain == ((1, 2, 3) if arrived else (1, 2))


def test_the_ground_behind_the_robot_ahead_is_not_the_ground_ahead() -> None:
    leads = poses(1, (0.0, 2.0, 0.0), (9.0, 4.0, 0.0))
    assert found([*leads, *poses(2, (0.0, 1.0, 0.0), (9.0, 3.0, 0.0))]).chain == (1,)


def test_a_loop_that_leads_back_to_the_place_ahead_is_not_the_ground_ahead() -> None:
    loop = [(3.73, 0.0), (3.73, 1.5), (2.5, 1.5), (2.5, 0.01), (3.73, 0.01), (4.0, 0.0)]
    leads = poses(1, *((2.0 * t_s, *at) for t_s, at in enumerate(loop)))
    beside = [*poses(2, (0.0, 3.73, 0.0)), *poses(3, (0.0, 3.0, 1.5))]
    assert found([*leads, *beside]).chain == (1, 2)


def test_a_strand_that_has_not_passed_the_place_of_a_robot_stands_on_straight_legs() -> None:
    leads = poses(1, (0.0, 3.6, 0.0), (9.0, 4.0, 0.0))
    finding = found([*leads, *poses(2, (0.0, 3.4, 0.0), (9.0, 3.73, 0.0)), *poses(3, (0.0, 3.46, 0.0))])
    assert finding.chain == (1, 2, 3)


def test_a_robot_that_was_killed_need_not_arrive() -> None:
    killed = {
        "kind": "fault.injected",
        "source": "world",
        "fault": "kill",
        "rule": "",
        "process": "r2",
        "t_s": 1.0,
    }
    assert found([*queue(4.0, 1.0), killed]).ok
    assert not found(queue(4.0, 1.0)).ok


def test_a_dead_body_nearer_to_the_goal_does_not_hide_those_that_arrived() -> None:
    killed = {
        "kind": "fault.injected",
        "source": "world",
        "fault": "kill",
        "rule": "",
        "process": "r1",
        "t_s": 1.0,
    }
    others = [*poses(2, (9.0, 4.0, 0.25)), *poses(3, (9.0, 4.0, 0.25 + KEEP_M))]
    goal = {"at_m": [4.0, 0.0], "tolerance_m": 0.3}
    finding = found([*poses(1, (9.0, 4.0, -0.2)), *others, killed], scenario(goal=goal))
    assert finding.chain == (2, 3)
    assert not finding.missed


def test_without_a_goal_the_longest_chain_has_arrived() -> None:
    finding = found(queue(4.0, 1.0, 1.0 + KEEP_M), scenario(goal=None))
    assert set(finding.chain) == {2, 3}
    assert [each[:7] for each in finding.missed] == ["robot 1"]


def test_a_run_in_which_no_body_was_placed_has_not_arrived() -> None:
    assert found([]).missed == ("nobody stands at the goal: inf m from it, at most 0.1200 m",)


micrometres = st.integers(-3_000_000, 3_000_000).map(lambda each: each / 1e6)
ways = st.lists(st.tuples(micrometres, micrometres), min_size=2, max_size=6)


@given(ways, ways, st.floats(0.1, 3.0))
@settings(max_examples=examples(100), deadline=None)
def test_no_moment_between_samples_is_nearer_than_the_least_distance(
    one: list[tuple[float, float]], other: list[tuple[float, float]], step_s: float
) -> None:
    rows = [[(i * each_s, *at) for i, at in enumerate(way)] for way, each_s in ((one, 1.0), (other, step_s))]
    least = found([*poses(1, *rows[0]), *poses(2, *rows[1])]).separation
    assert least is not None
    times_s = np.append(np.linspace(0.0, max(rows[0][-1][0], rows[1][-1][0]), 2000), least.t_s)
    at = [np.stack([np.interp(times_s, *np.array(each).T[[0, k]]) for k in (1, 2)]) for each in rows]
    apart_m = np.hypot(*(at[0] - at[1])) - 0.2
    assert apart_m.min() >= least.distance_m - 1e-9
    assert apart_m[-1] == pytest.approx(least.distance_m, abs=1e-6), (
        "it is so near at the moment that it names"
    )


def test_a_robot_without_a_pose_has_not_arrived() -> None:
    fleet = {**scenario()["fleet"], "robots": 2}
    finding = found(poses(1, (0.0, 0.0, 0.0)), scenario(fleet=fleet))
    assert "robot 2 has no pose" in finding.missed
