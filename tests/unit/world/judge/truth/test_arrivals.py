"""A1 and A2: the goal and the places that robots record, held against true poses."""

import random

import pytest
from msgspec.structs import replace

from protocol.fence import May
from protocol.frames import Point
from protocol.timeline import (
    GoalReached,
    Record,
    RobotArrived,
    RobotDied,
    RobotStarted,
    StepAbandoned,
    StepPlanned,
    StrandJoined,
)
from tests.support.histories.arriving import (
    EPOCH,
    GOAL_M,
    KEEP_M,
    NEXT,
    SCENE,
    breaches,
    broken,
    fence,
    finished,
    formation,
    order,
    plan,
    pose,
    run,
)
from tests.support.histories.entries import Said, lines_of
from world.judge.judgement import judge

SHORT_M = 0.33


def test_a_strand_that_arrives_breaks_nothing() -> None:
    assert broken(run()) == []


def leader_stops_at(x_m: float) -> list[Said]:
    """The leader ends its step at x, and says that this is the goal; the others come up behind it."""
    back_m = GOAL_M - x_m
    return run(
        plan_1=(0.9, "r1", replace(plan(), target=Point(x_m=x_m, y_m=0.0))),
        order_1=(1.0, "world", order(1, 0.0, x_m, step=1)),
        finished_1=(3.0, "world", finished(x_m)),
        goal_1=(3.0, "r1", GoalReached(x_m=GOAL_M, y_m=0.0)),
        there_1=(3.0, "world", pose(1, x_m)),
        end_1=(9.0, "world", pose(1, x_m)),
        arrived_1=(3.0, "r1", RobotArrived(progress_m=2.2 - back_m)),
        there_2=(5.7, "world", pose(2, x_m - KEEP_M)),
        end_2=(9.0, "world", pose(2, x_m - KEEP_M)),
        arrived_2=(5.7, "r2", RobotArrived(progress_m=2.2 - KEEP_M - back_m)),
        there_3=(8.9, "world", pose(3, x_m - 2 * KEEP_M)),
        end_3=(9.0, "world", pose(3, x_m - 2 * KEEP_M)),
        arrived_3=(8.9, "r3", RobotArrived(progress_m=2.2 - 2 * KEEP_M - back_m)),
    )


@pytest.mark.parametrize(("short_m", "found"), [(0.0, []), (0.16, []), (0.18, ["A1"]), (SHORT_M, ["A1"])])
def test_a_leader_reaches_the_goal_within_the_tolerance_and_mu0(short_m: float, found: list[str]) -> None:
    shown = breaches(leader_stops_at(GOAL_M - short_m))
    assert [breach.invariant for breach in shown] == found
    assert [breach.measured_m for breach in shown] == pytest.approx([short_m] * len(found))


def follower_stops_at(x_m: float, *, says_m: float | None = None) -> list[Said]:
    """The last robot stops at x, and says that it has arrived there, or elsewhere."""
    progress_m = x_m + 1.2 if says_m is None else says_m
    return run(
        there_3=(8.9, "world", pose(3, x_m)),
        end_3=(9.0, "world", pose(3, x_m)),
        arrived_3=(8.9, "r3", RobotArrived(progress_m=progress_m)),
    )


DRIVES = ("plan 1", "order 1", "drive 1", "half 1", "finished 1", "there 1", "order 2", "drive 2", "there 2")
POINT_0, POINT_1 = Point(x_m=-1.2, y_m=0.0), Point(x_m=GOAL_M, y_m=0.0)
PLACE_3_M = GOAL_M - 2 * KEEP_M


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (follower_stops_at(PLACE_3_M - 0.015), None),  # within mu0
        (follower_stops_at(PLACE_3_M - 0.025), "has not come up to the robot ahead"),
        (follower_stops_at(-1.2), "has not come up to the robot ahead"),  # 1.56 m short
        (follower_stops_at(-1.2, says_m=PLACE_3_M + 1.2), "does not stand there on its path"),
        (follower_stops_at(PLACE_3_M + 0.01), "nearer to the robot ahead than robots keep"),
    ],
)
def test_a_follower_arrives_where_it_can_come_no_nearer(said: list[Said], why: str | None) -> None:
    shown = breaches(said)
    assert [(breach.invariant, breach.robot) for breach in shown] == ([] if why is None else [("A2", 3)])
    assert why is None or shown[0].why.endswith(why)


@pytest.mark.parametrize("said", [leader_stops_at(GOAL_M - SHORT_M), follower_stops_at(-1.2)])
def test_the_verdict_counts_no_untrue_arrival(said: list[Said]) -> None:
    judgement = judge(SCENE, lines_of(said))
    assert judgement.violations["A1"] + judgement.violations["A2"] == 1
    assert len(judgement.untrue) == 1


WRONG: dict[str, tuple[list[tuple[str, int]], list[Said]]] = {
    "the leader says nothing of the goal": ([("A2", 1)], run(without=("goal 1",))),
    "the robot ahead never arrives": ([("A2", 3)], run(without=("arrived 2",))),
    "all that follow a silent leader": ([("A2", 2)], run(without=("arrived 1",))),
    "a leader that moves on": ([("A2", 1)], run((7.0, "world", pose(1, GOAL_M + 0.01)))),
    "a follower that moves on": ([("A2", 2)], run((7.0, "world", pose(2, GOAL_M - KEEP_M - 0.01)))),
    "one that says so on its way": (
        [("A2", 2)],
        run(arrived_2=(4.7, "r2", RobotArrived(progress_m=2.2 - KEEP_M - 0.5))),
    ),
}


@pytest.mark.parametrize(("found", "said"), WRONG.values(), ids=WRONG.keys())
def test_arrivals_that_poses_or_others_do_not_bear_out_are_found(
    found: list[tuple[str, int]], said: list[Said]
) -> None:
    assert set(broken(said)) == set(found)


LAWFUL: dict[str, list[Said]] = {
    "it moves in the next epoch": run(
        (9.05, "world", fence(NEXT, 0, May.NOBODY)), (9.07, "world", pose(1, GOAL_M + 0.3))
    ),
    "the robot ahead died before it could record it": run(
        (6.0, "world", RobotDied(robot=2, silent_since_s=5.8)), without=("arrived 2", "settled 2")
    ),
    "the robot ahead was started again": run(
        (6.0, "r2", RobotStarted(pid=2, incarnation="i")), without=("arrived 2",)
    ),
    "the formation was never recorded": run(without=("formed",)),
}


@pytest.mark.parametrize("said", LAWFUL.values(), ids=LAWFUL.keys())
def test_what_excuses_a_robot_is_no_violation(said: list[Said]) -> None:
    assert broken(said) == []


def test_a_follower_may_stand_nearer_where_the_formation_has_its_place() -> None:
    near_m = GOAL_M - KEEP_M + 0.05
    at_goal = replace(formation(1, 2), places_m=(2.2, 1.2 + near_m), laid=(POINT_0, POINT_1))
    shown: dict[str, Record] = {
        "place_1": pose(1, GOAL_M),
        "place_2": pose(2, near_m),
        "end_2": pose(2, near_m),
    }
    stand: dict[str, Said] = {name: (0.0, "world", record) for name, record in shown.items()}
    stand["arrived_2"] = (5.7, "r2", RobotArrived(progress_m=1.2 + near_m))
    stand["formed"] = (0.3, "r1", at_goal)
    assert broken(run(without=(*DRIVES, "arrived 3"), **stand)) == []
    stand["formed"] = (0.3, "r1", replace(at_goal, places_m=(2.2, 1.2)))
    assert broken(run(without=(*DRIVES, "arrived 3"), **stand)) == [("A2", 2)]


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize(("said", "found"), [(run(), set()), (follower_stops_at(-1.2), {("A2", 3)})])
def test_robots_whose_entries_come_late_are_judged_alike(
    seed: int, said: list[Said], found: set[tuple[str, int]]
) -> None:
    draws = random.Random(seed)
    late_s = {"world": 0.0, **{source: draws.uniform(0.0, 9.0) for source in ("r1", "r2", "r3")}}
    assert set(broken(sorted(said, key=lambda each: each[0] + late_s[each[1]]))) == found


def test_without_a_goal_the_leader_stands_at_its_last_switching_position() -> None:
    scene = replace(SCENE, goal=None)
    assert breaches(run(), scene) == []
    short = leader_stops_at(GOAL_M - SHORT_M)
    assert breaches(short, scene) == [], "it planned no further"
    ordered: Said = (1.0, "world", order(1, 0.0, GOAL_M, step=1))
    elsewhere = [each for each in short if not isinstance(each[2], StepPlanned) and each[0] != 1.0] + [
        ordered
    ]
    shown = breaches([*elsewhere, (0.9, "r1", plan())], scene)
    assert {breach.invariant for breach in shown} >= {"A1"}
    abandoned = StepAbandoned(step=1, epoch=EPOCH, x_m=GOAL_M - SHORT_M, y_m=0.0)
    gave_up = [*elsewhere, (0.9, "r1", plan()), (2.9, "r1", abandoned)]
    assert breaches(sorted(gave_up, key=at_s), scene) == []


def at_s(said: Said) -> float:
    return said[0]


def test_a_chain_of_5_000_arrivals_from_the_tail_on_is_judged_without_recursion() -> None:
    fleet = tuple(range(1, 5_001))
    places_m = tuple((len(fleet) - robot) * KEEP_M for robot in fleet)
    laid = (Point(x_m=0.0, y_m=0.0), Point(x_m=places_m[0], y_m=0.0))
    said: list[Said] = [
        *((0.0, "world", pose(robot, x_m)) for robot, x_m in zip(fleet, places_m, strict=True)),
        (0.4, "world", fence(EPOCH, 1, May.ALL, leader=1)),
        *((0.5, f"r{robot}", StrandJoined(epoch=EPOCH, rank=robot - 1)) for robot in fleet),
        *((1.0, f"r{robot}", RobotArrived(progress_m=places_m[robot - 1])) for robot in reversed(fleet)),
        (2.0, "world", pose(1, places_m[0])),
        (2.1, "r1", replace(formation(*fleet), places_m=places_m, laid=laid)),
    ]
    assert broken(said) == [("A2", 1)], "it has not said that the goal is reached"
