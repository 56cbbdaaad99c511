"""The order of a strand, from where its robots stand."""

import math
from collections.abc import Sequence
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from agents.coordinating.order import (
    chain,
    former_order,
    in_front,
    kept_order,
    order_at_start,
    other_order,
)
from protocol.fence import Epoch
from protocol.frames import Point, Pose
from protocol.wire.view import Former, Report

GOAL = Point(x_m=5.0, y_m=0.0)

# Half metres make robots equally near, so that ties come up.
halves = st.integers(-6, 6).map(lambda half: half / 2.0)
poses = st.builds(Pose, x_m=halves, y_m=halves, heading_rad=st.just(0.0))
goals = st.builds(Point, x_m=halves, y_m=halves)
distances_m = st.sampled_from([0.5, 1.0, 1.5, 4.0])


def standing(*places: tuple[float, float]) -> dict[int, Pose]:
    """Robots 1, 2, ... at these places."""
    return {
        robot: Pose(x_m=x_m, y_m=y_m, heading_rad=0.0) for robot, (x_m, y_m) in enumerate(places, start=1)
    }


def numbered(poses_of_robots: Sequence[Pose]) -> dict[int, Pose]:
    return dict(enumerate(poses_of_robots, start=1))


def apart_m(a: Pose, b: Pose) -> float:
    return math.hypot(a.x_m - b.x_m, a.y_m - b.y_m)


places_of_robots = st.lists(poses, min_size=1, max_size=7).map(numbered)


@given(places_of_robots, st.data())
def test_behind_each_robot_comes_the_nearest_of_those_still_waiting(
    places: dict[int, Pose], data: st.DataObject
) -> None:
    leader = data.draw(st.sampled_from(sorted(places)))
    order = chain(places, leader)
    assert order[0] == leader
    assert sorted(order) == sorted(places)
    for rank, (ahead, behind) in enumerate(pairwise(order), start=1):
        nearest = min((apart_m(places[ahead], places[robot]), robot) for robot in order[rank:])
        assert nearest[1] == behind


@given(places_of_robots, st.data())
def test_without_a_goal_the_robot_nearest_to_an_obstacle_leads_and_ties_go_to_the_lowest_number(
    places: dict[int, Pose], data: st.DataObject
) -> None:
    obstacle_m = {robot: data.draw(distances_m) for robot in places}
    order = order_at_start(places, None, obstacle_m)
    nearest_m = min(obstacle_m.values())
    assert order == chain(places, min(robot for robot in places if obstacle_m[robot] == nearest_m))


@given(places_of_robots, goals)
def test_with_a_goal_no_strand_from_the_nearest_robot_or_from_its_ends_has_less_to_drive(
    places: dict[int, Pose], goal: Point
) -> None:
    order = order_at_start(places, goal, {})
    off_m = {robot: math.hypot(pose.x_m - goal.x_m, pose.y_m - goal.y_m) for robot, pose in places.items()}
    nearest = chain(places, min(places, key=lambda robot: (off_m[robot], robot)))
    from_its_end = chain(places, nearest[-1])
    candidates = [nearest, from_its_end, chain(places, from_its_end[-1])]
    ways_m = [
        sum(apart_m(places[a], places[b]) for a, b in pairwise(each)) + off_m[each[0]] for each in candidates
    ]
    assert order in candidates
    assert ways_m[candidates.index(order)] == min(ways_m)


def test_a_queue_is_led_by_its_end_at_the_goal_even_if_another_robot_touches_an_obstacle() -> None:
    queue = standing((0.0, 0.0), (1.0, 0.0), (2.0, 0.0))
    assert order_at_start(queue, GOAL, {}) == (3, 2, 1)
    assert order_at_start(queue, None, {1: 0.1, 2: 1.0, 3: 2.0}) == (1, 2, 3)


def test_a_queue_beside_its_goal_is_led_from_an_end_and_not_from_its_middle() -> None:
    queue = standing(*((float(x), 0.0) for x in range(5)))
    assert order_at_start(queue, Point(x_m=2.0, y_m=1.0), {}) == (1, 2, 3, 4, 5)


# --- places that were kept ------------------------------------------------------------------------------

LAST, VIEW = (Epoch(generation=each, robot=1, life=1) for each in (2, 3))
QUEUE = standing((2.0, 0.0), (1.0, 0.0), (0.0, 0.0), (-1.0, 0.0), (3.0, 0.0))


def test_robots_that_have_stayed_keep_their_order_and_the_others_come_behind_them() -> None:
    assert kept_order(QUEUE, (3, 2), ()) == (3, 2, 1, 5, 4)


def test_a_robot_that_tells_two_places_in_one_formation_has_stayed_once() -> None:
    twice = tuple(Former(epoch=LAST, rank=rank, at=GOAL) for rank in (0, 2))
    reports = {
        robot: Report(epoch=VIEW, life=robot, number=1, turn=0, place=QUEUE[robot], formers=formers)
        for robot, formers in ((1, (Former(epoch=LAST, rank=1, at=GOAL),)), (2, twice))
    }
    assert sorted(former_order(reports)) == [1, 2]


def test_robots_that_stand_in_front_of_those_that_have_stayed_lead_them() -> None:
    front = in_front(QUEUE, (1, 2, 3), GOAL)
    assert front == (5,)
    assert kept_order(QUEUE, (1, 2, 3), front) == (5, 1, 2, 3, 4)


def test_in_front_of_a_robot_that_stayed_alone_are_those_nearer_to_the_goal() -> None:
    assert in_front(QUEUE, (1,), GOAL) == (5,)
    assert in_front(QUEUE, (1,), None) == ()


def test_where_nobody_has_stayed_in_front_nobody_leads_but_the_first_that_stayed() -> None:
    assert in_front(QUEUE, (5, 1, 2), GOAL) == ()


def test_where_leaders_have_led_in_vain_the_nearest_to_the_goal_leads_that_has_not_led() -> None:
    three = {robot: QUEUE[robot] for robot in (1, 2, 3)}
    orders = [other_order(three, led, GOAL) for led in ((1,), (2,), (3, 1), (1, 2), (1, 2, 3))]
    assert orders == [(2, 1, 3), (1, 2, 3), (2, 1, 3), (3, 2, 1), (1, 2, 3)]
    assert other_order(three, (3, 2, 1), GOAL) == (3, 2, 1), "where all have led, the one that did so first"
