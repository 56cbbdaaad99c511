import math
from collections.abc import Sequence
from itertools import pairwise

import pytest
from agents.membership.muster import (
    Roster,
    chain,
    folds_back,
    in_place_at_start,
    order_with_goal,
    order_without_goal,
)
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from protocol.frames import Point, Pose
from protocol.wire.messages import Attempt, Former, Muster, Turn

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


LEAST_M = 0.25


def roster_of(robots: int, goal: Point | None) -> Roster:
    return Roster(tuple(range(1, robots + 1)), goal, LEAST_M)


def said(pose: Pose, number: int = 1, **news: object) -> Muster:
    return replace(Muster(number=number, pose=pose), **news)


@given(places_of_robots, st.one_of(st.none(), goals), st.data())
def test_all_compute_the_same_order_however_often_and_in_whatever_order_they_hear_it(
    places: dict[int, Pose], goal: Point | None, data: st.DataObject
) -> None:
    obstacle_m = {robot: data.draw(distances_m) for robot in places}
    early = [(robot, said(pose)) for robot, pose in places.items()]
    full = [(robot, said(pose, 2, obstacle_m=obstacle_m[robot])) for robot, pose in places.items()]
    rosters = [roster_of(len(places), goal), roster_of(len(places), goal)]
    for roster in rosters:
        for robot, muster in data.draw(st.permutations(early + full + full)):
            roster.hear(robot, muster)
    assert rosters[0].start_order == rosters[1].start_order
    assert sorted(rosters[0].start_order) == sorted(places)


@given(places_of_robots, goals, st.data())
def test_an_announcement_with_an_older_number_is_late_and_changes_nothing(
    places: dict[int, Pose], goal: Point, data: st.DataObject
) -> None:
    roster = roster_of(len(places), goal)
    for robot, pose in places.items():
        assert roster.hear(robot, said(pose, 5))
    late = data.draw(st.sampled_from(sorted(places)))
    for number in (1, 5):
        assert not roster.hear(late, said(data.draw(poses), number, rank=1))
    assert roster.places == places


@given(places_of_robots, goals, st.data())
def test_the_order_stays_as_it_was_when_robots_move(
    places: dict[int, Pose], goal: Point, data: st.DataObject
) -> None:
    roster = roster_of(len(places), goal)
    for robot, pose in places.items():
        roster.hear(robot, said(pose))
    order = roster.start_order
    mover = data.draw(st.sampled_from(sorted(places)))
    roster.hear(mover, said(data.draw(poses), 2))
    assert roster.start_order == order


@pytest.mark.parametrize("goal", [None, GOAL])
def test_there_is_no_order_before_all_have_been_heard(goal: Point | None) -> None:
    places = standing((0.0, 0.0), (1.0, 0.0), (2.0, 0.0))
    roster = roster_of(3, goal)
    for robot in (1, 3):
        roster.hear(robot, said(places[robot], obstacle_m=1.0))
        assert (roster.places, roster.start_order, roster.agreed()) == (None, (), False)
    roster.hear(2, said(places[2], obstacle_m=1.0))
    assert roster.places == places
    assert len(roster.start_order) == 3


def test_without_a_goal_there_is_no_order_before_all_have_sensed() -> None:
    places = standing((0.0, 0.0), (1.0, 0.0))
    roster = roster_of(2, None)
    roster.hear(1, said(places[1], obstacle_m=1.0))
    roster.hear(2, said(places[2]))
    assert not roster.start_order
    roster.hear(2, said(places[2], 2, obstacle_m=0.5))
    assert roster.start_order == (2, 1)


def looked(places: dict[int, Pose], *clear: bool) -> Roster:
    """All robots know the order and have looked at their legs."""
    roster = roster_of(len(places), GOAL)
    for (robot, pose), leg_clear in zip(places.items(), clear, strict=True):
        roster.hear(robot, said(pose, leg_clear=leg_clear))
    return roster


QUEUE = ((2.0, 0.0), (1.0, 0.0), (0.0, 0.0))


def test_nobody_is_in_place_before_all_have_looked_at_their_legs() -> None:
    roster = roster_of(3, GOAL)
    places = standing(*QUEUE)
    for robot, pose in places.items():
        roster.hear(robot, said(pose, leg_clear=True if robot < 3 else None))
    assert roster.strand == ()


@pytest.mark.parametrize(
    ("clear", "strand"),
    [
        ((True, True, True), (1, 2, 3)),
        ((True, True, False), (1, 2)),
        ((True, False, True), (1,)),
    ],
)
def test_in_place_at_the_start_are_those_up_to_the_first_leg_that_is_not_clear(
    clear: tuple[bool, ...], strand: tuple[int, ...]
) -> None:
    assert looked(standing(*QUEUE), *clear).strand == strand


def test_in_place_at_the_start_are_those_up_to_the_first_that_folds_back() -> None:
    places = standing((0.0, 0.0), (-0.26, 0.1), (-0.26, -0.15), (-1.0, -0.1))
    assert looked(places, True, True, True, True).strand == (1, 2)


@given(places_of_robots.filter(lambda places: len(places) > 1), goals)
def test_as_many_are_in_place_at_the_start_as_do_not_fold_back_one_by_one(
    places: dict[int, Pose], goal: Point
) -> None:
    order = order_with_goal(places, goal)
    count = in_place_at_start(places, order, least_m=LEAST_M)
    folds = [folds_back(places, order[:length], least_m=LEAST_M) for length in range(1, len(order) + 1)]
    assert folds == [length > count for length in range(1, len(order) + 1)]


def test_who_came_to_a_place_by_a_turn_is_in_place_behind_those() -> None:
    places = standing(*QUEUE)
    roster = looked(places, True, False, False)
    roster.hear(3, said(places[3], 2, leg_clear=False, rank=1))
    roster.hear(2, said(places[2], 2, leg_clear=False, rank=2))
    assert roster.strand == (1, 3, 2)


def test_who_gave_up_its_place_and_all_behind_it_are_not_in_place_any_more() -> None:
    places = standing(*QUEUE)
    roster = looked(places, True, True, True)
    roster.hear(2, said(places[2], 2, leg_clear=True, ended=1))
    assert roster.strand == (1,)


def test_a_turn_may_be_used_when_all_others_have_said_that_they_know_of_it() -> None:
    places, turn = standing(*QUEUE), Turn(number=4, robot=2)
    roster = looked(places, True, False, False)
    roster.hear(1, said(places[1], 2, turn=4, gives=turn))
    assert roster.turn == turn
    assert not roster.all_stand_in(turn, since_s=0.0, now_s=9.0)
    roster.hear(3, said(places[3], 2, turn=3))
    assert not roster.all_stand_in(turn, since_s=0.0, now_s=9.0)
    roster.hear(3, said(places[3], 3, turn=4))
    assert roster.all_stand_in(turn, since_s=0.0, now_s=9.0)


def test_a_turn_may_be_used_only_while_all_others_answer_to_what_was_said_of_late() -> None:
    places, turn = standing(*QUEUE), Turn(number=1, robot=2)
    roster = looked(places, True, False, False)
    roster.hear(1, said(places[1], 2, turn=1, gives=turn, echo_s=5.0))
    roster.hear(3, said(places[3], 2, turn=1, echo_s=4.0))
    assert [roster.all_stand_in(turn, since_s=since_s, now_s=9.0) for since_s in (3.9, 4.0, 4.1)] == [
        True,
        True,
        False,
    ]


def test_the_strand_is_agreed_only_when_all_have_announced_that_very_strand() -> None:
    places = standing((1.0, 0.0), (0.0, 0.0))
    roster = looked(places, True, True)
    for number, order in enumerate([(), (2, 1)], start=2):
        for robot, mine in ((1, (1, 2)), (2, order)):
            roster.hear(robot, said(places[robot], number, leg_clear=True, order=mine))
        assert not roster.agreed()
    roster.hear(2, said(places[2], 9, leg_clear=True, order=(1, 2)))
    assert roster.agreed()


def test_a_robot_that_has_been_left_out_is_not_waited_for_and_not_heard() -> None:
    places = standing((2.0, 0.0), (1.0, 0.0), (0.0, 0.0))
    roster = Roster((1, 3), GOAL, LEAST_M)
    for robot in (1, 3):
        assert roster.hear(robot, said(places[robot]))
    assert not roster.hear(2, said(places[2]))
    assert (roster.places, roster.start_order) == ({1: places[1], 3: places[3]}, (1, 3))


def test_a_robot_that_is_not_of_the_fleet_is_not_heard() -> None:
    roster = roster_of(1, GOAL)
    for stranger in (0, 2):
        assert not roster.hear(stranger, said(standing((0.0, 0.0))[1]))
    assert roster.places is None


@pytest.mark.parametrize(
    ("led", "order"),
    [
        ((1,), (2, 1, 3)),
        ((2,), (1, 2, 3)),
        ((3, 1), (2, 1, 3)),
        ((1, 2), (3, 2, 1)),
        ((1, 2, 3), (1, 2, 3)),  # who had not led is no member any more
    ],
)
def test_where_orders_were_tried_in_vain_the_nearest_to_the_goal_leads_of_those_who_have_not_yet(
    led: tuple[int, ...], order: tuple[int, ...]
) -> None:
    roster = Roster((1, 2, 3), GOAL, LEAST_M, Attempt(trial=False, led=led))
    for robot, pose in standing(*QUEUE).items():
        roster.hear(robot, said(pose, formers=(Former(epoch=1, rank=3 - robot, progress_m=float(robot)),)))
    assert roster.start_order == order, "whatever strand they were in"
    assert roster.next_attempt == Attempt(trial=False, led=(*led, order[0]))


@pytest.mark.parametrize(
    ("goal_m", "led", "leads_next"), [(2.5, (), None), (1.0, (), 2), (-1.0, (), 3), (1.0, (2,), None)]
)
def test_who_leads_next_and_stands_in_front_is_nearer_to_the_goal_than_the_leader(
    goal_m: float, led: tuple[int, ...], leads_next: int | None
) -> None:
    """Robot 1 has led the others, and stands at 2 m, they behind it."""
    roster = Roster((1, 2, 3), Point(x_m=goal_m, y_m=0.0), LEAST_M, Attempt(trial=False, led=led))
    for robot, pose in standing(*QUEUE).items():
        former = Former(epoch=1, rank=robot - 1, progress_m=3.0 - robot)
        roster.hear(robot, said(pose, formers=() if led else (former,)))
    assert roster.leads_next == leads_next


@pytest.mark.parametrize(
    ("strand", "goes_on"),
    [((1, 2), True), ((1,), False), ((2, 3), False)],
    ids=["most", "one", "not first"],
)
def test_those_in_place_go_on_without_the_others_if_they_are_most_and_nobody_is_nearer_to_the_goal(
    strand: tuple[int, ...], *, goes_on: bool
) -> None:
    roster = Roster((1, 2, 3), GOAL, LEAST_M)
    for robot, pose in standing(*QUEUE).items():
        roster.hear(robot, said(pose))
    assert roster.leads_on(strand) is goes_on


def test_without_a_goal_nobody_goes_on_without_the_others() -> None:
    roster = Roster((1, 2, 3), None, LEAST_M)
    for robot, pose in standing(*QUEUE).items():
        roster.hear(robot, said(pose))
    assert not roster.leads_on((1, 2))
