import math
from collections.abc import Sequence
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.muster import Roster, chain, order_with_goal, order_without_goal
from protocol.frames import Point, Pose
from protocol.messages import Muster

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
    order = order_without_goal(places, obstacle_m)
    nearest_m = min(obstacle_m.values())
    assert order == chain(places, min(robot for robot in places if obstacle_m[robot] == nearest_m))


@given(places_of_robots, goals)
def test_with_a_goal_no_strand_from_the_nearest_robot_or_from_its_ends_has_less_to_drive(
    places: dict[int, Pose], goal: Point
) -> None:
    order = order_with_goal(places, goal)
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
    assert order_with_goal(queue, GOAL) == (3, 2, 1)
    assert order_without_goal(queue, {1: 0.1, 2: 1.0, 3: 2.0}) == (1, 2, 3)


def test_a_queue_beside_its_goal_is_led_from_an_end_and_not_from_its_middle() -> None:
    queue = standing(*((float(x), 0.0) for x in range(5)))
    assert order_with_goal(queue, Point(x_m=2.0, y_m=1.0)) == (1, 2, 3, 4, 5)


def said(pose: Pose, obstacle_m: float | None, order: tuple[int, ...]) -> Muster:
    return Muster(pose=pose, obstacle_m=obstacle_m, order=order)


@given(places_of_robots, st.one_of(st.none(), goals), st.data())
def test_all_compute_the_same_order_however_often_and_in_whatever_order_they_hear_it(
    places: dict[int, Pose], goal: Point | None, data: st.DataObject
) -> None:
    obstacle_m = {robot: data.draw(distances_m) for robot in places}
    early = [(robot, said(pose, None, ())) for robot, pose in places.items()]
    full = [(robot, said(pose, obstacle_m[robot], ())) for robot, pose in places.items()]
    rosters = [Roster(len(places), goal), Roster(len(places), goal)]
    for roster in rosters:
        for robot, muster in data.draw(st.permutations(early + full + full)):
            roster.hear(robot, muster)
    assert rosters[0].order() == rosters[1].order()
    assert sorted(rosters[0].order()) == sorted(places)


@given(places_of_robots, goals, st.data())
def test_an_announcement_that_knows_less_is_late_and_changes_nothing(
    places: dict[int, Pose], goal: Point, data: st.DataObject
) -> None:
    roster = Roster(len(places), goal)
    order = order_with_goal(places, goal)
    for robot, pose in places.items():
        roster.hear(robot, said(pose, 1.0, order))
    late = data.draw(st.sampled_from(sorted(places)))
    for muster in (said(data.draw(poses), None, ()), said(data.draw(poses), 2.0, ())):
        roster.hear(late, muster)
    assert roster.places == places
    assert roster.agreed()


@pytest.mark.parametrize("goal", [None, GOAL])
def test_there_is_no_order_before_all_have_been_heard(goal: Point | None) -> None:
    places = standing((0.0, 0.0), (1.0, 0.0), (2.0, 0.0))
    roster = Roster(3, goal)
    for robot in (1, 3):
        roster.hear(robot, said(places[robot], 1.0, ()))
        assert (roster.places, roster.order(), roster.agreed()) == (None, (), False)
    roster.hear(2, said(places[2], 1.0, ()))
    assert roster.places == places
    assert len(roster.order()) == 3


def test_without_a_goal_there_is_no_order_before_all_have_sensed() -> None:
    places = standing((0.0, 0.0), (1.0, 0.0))
    roster = Roster(2, None)
    roster.hear(1, said(places[1], 1.0, ()))
    roster.hear(2, said(places[2], None, ()))
    assert roster.order() == ()
    roster.hear(2, said(places[2], 0.5, ()))
    assert roster.order() == (2, 1)


def test_the_order_is_agreed_only_when_all_have_announced_that_very_order() -> None:
    places = standing((0.0, 0.0), (1.0, 0.0))
    roster = Roster(2, GOAL)
    roster.hear(1, said(places[1], None, (2, 1)))
    roster.hear(2, said(places[2], None, ()))
    assert not roster.agreed()
    roster.hear(2, said(places[2], None, (1, 2)))
    assert not roster.agreed()
    roster.hear(2, said(places[2], None, (2, 1)))
    assert roster.agreed()


def test_the_order_follows_what_is_known_of_the_places() -> None:
    places = standing((0.0, 0.0), (1.0, 0.0))
    roster = Roster(2, GOAL)
    for robot, pose in places.items():
        roster.hear(robot, said(pose, None, ()))
    assert roster.order() == (2, 1)
    roster.hear(1, said(standing((4.0, 0.0))[1], None, ()))
    assert roster.order() == (1, 2)


def test_a_robot_that_is_not_of_the_fleet_is_not_heard() -> None:
    roster = Roster(1, GOAL)
    for stranger in (0, 2):
        roster.hear(stranger, said(standing((0.0, 0.0))[1], None, ()))
    assert roster.places is None
