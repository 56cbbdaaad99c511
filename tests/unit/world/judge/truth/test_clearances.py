"""S4: the clearance that was promised for a step, held against the one that was kept."""

import pytest
from msgspec.structs import replace

from protocol.fence import May
from protocol.frames import Point
from protocol.timeline import OrderFinished, RobotDied, StepFinished
from tests.support.histories.arriving import (
    EPOCH,
    GOAL_M,
    LEFT_M,
    NEXT,
    SCENE,
    breaches,
    broken,
    fence,
    order,
    plan,
    pose,
    run,
)
from tests.support.histories.entries import Said

MU0_M = 0.02
INFLATED_M = 0.03


def promised(promised_m: float | None, *, without: tuple[str, ...] = ()) -> list[Said]:
    return run(plan_1=(0.9, "r1", plan(promised_m)), without=without)


@pytest.mark.parametrize("more_m", [-0.1, 0.0, MU0_M])
def test_a_promise_that_was_kept_within_mu0_is_no_violation(more_m: float) -> None:
    assert broken(promised(LEFT_M + more_m)) == []


@pytest.mark.parametrize("late_s", [0.0, 5.0], ids=["planned in time", "recorded late"])
def test_a_promise_of_30_mm_more_than_was_kept_is_found(late_s: float) -> None:
    said = sorted(promised(LEFT_M + INFLATED_M), key=lambda each: each[0] + late_s * (each[1] == "r1"))
    (breach,) = breaches(said)
    assert (breach.invariant, breach.robot) == ("S4", 1)
    assert breach.measured_m == pytest.approx(LEFT_M)
    assert breach.required_m == pytest.approx(LEFT_M + INFLATED_M - MU0_M)


def test_the_clearance_is_that_of_the_whole_step_by_true_poses() -> None:
    swerves = run((2.5, "world", replace(pose(1, 1.2), y_m=0.2)), finished_1=(3.0, "world", said_wide()))
    (breach,) = [each for each in breaches(swerves) if each.invariant == "S4"]
    assert breach.measured_m == pytest.approx(0.5 - 0.4, abs=0.01)


def said_wide() -> StepFinished:
    """What the world has measured counts no more than what robots say."""
    return StepFinished(robot=1, step=1, x_m=GOAL_M, y_m=0.0, clearance_m=9.0)


def test_a_step_that_never_ends_is_judged_as_far_as_it_was_driven() -> None:
    cut = ("finished 1", "goal 1", "arrived 1", "arrived 2", "arrived 3")
    assert broken(promised(LEFT_M + INFLATED_M, without=cut)) == [("S4", 1)]
    begun = (*cut, "there 1", "end 1")
    assert broken(promised(LEFT_M + INFLATED_M, without=begun)) == [], "half of the way was clear enough"
    raised: Said = (2.5, "world", fence(NEXT, 0, May.NOBODY))
    assert broken(run(raised, plan_1=(0.9, "r1", plan(LEFT_M + INFLATED_M)), without=cut)) == []


@pytest.mark.parametrize("late", ["r1", "r2", "r3"])
def test_a_log_that_is_cut_off_is_not_called_broken_for_entries_of_robots_that_come_late(late: str) -> None:
    lines = sorted(run(), key=lambda said: said[0] + 5.0 * (said[1] == late))
    assert broken(lines) == []
    cuts = [lines[:cut] for cut in range(1, len(lines))]
    assert all(broken(cut, cut_off=True) == [] for cut in cuts)
    assert any(broken(cut) for cut in cuts), "the cuts are between what is done and what allows it"


def test_what_a_log_that_is_cut_off_shows_broken_is_found() -> None:
    cut = ("finished 1", "goal 1", "arrived 1", "arrived 2", "arrived 3")
    assert broken(promised(LEFT_M + INFLATED_M, without=cut), cut_off=True) == [("S4", 1)]


def test_a_step_that_was_interrupted_and_resumed_is_one_step() -> None:
    stands: Said = (2.0, "world", replace(order(1, 0.5, 0.0), target=None))
    again: Said = (2.2, "world", order(1, 0.5, GOAL_M, step=1))
    assert broken([*run(stands, again)]) == []
    inflated = run(stands, again, plan_1=(0.9, "r1", plan(LEFT_M + INFLATED_M)))
    assert broken(inflated) == [("S4", 1)]


def joined(promised_m: float) -> list[Said]:
    """Robot 3 has the turn and drives a step towards its place."""
    target = Point(x_m=GOAL_M, y_m=0.0)
    turn = replace(fence(EPOCH, 1, May.ONE), named=3, named_life="a")
    return [
        (0.0, "world", pose(3, 0.0)),
        (0.2, "world", turn),
        (0.3, "r3", replace(plan(promised_m), joins=True)),
        (0.4, "world", order(3, 0.0, GOAL_M)),
        (2.4, "world", OrderFinished(robot=3, number=1, step=0, x_m=target.x_m, y_m=0.0, clearance_m=None)),
        (2.4, "world", pose(3, GOAL_M)),
    ]


def test_robots_that_join_keep_what_they_promise_too() -> None:
    assert broken(joined(LEFT_M)) == []
    assert broken(joined(LEFT_M + INFLATED_M)) == [("S4", 3)]


def test_of_two_steps_of_a_robot_that_joins_to_one_target_each_has_its_own_promise() -> None:
    from_nearer = replace(plan(LEFT_M + INFLATED_M), joins=True, reach_m=0.1)
    assert broken([*joined(LEFT_M)[:2], (0.25, "r3", from_nearer), *joined(LEFT_M)[2:]]) == []


def test_a_step_for_which_nothing_was_promised_is_found() -> None:
    assert broken(promised(None)) == [("S4", 1)]
    elsewhere = replace(order(1, 0.0, GOAL_M + 5e-7, step=1))
    assert broken(run(order_1=(1.0, "world", elsewhere))) == [("S4", 1)], "no promise is for that target"


def test_the_promise_of_a_robot_that_died_on_its_way_may_be_missing() -> None:
    cut = ("plan 1", "finished 1", "goal 1", "arrived 1", "arrived 2", "arrived 3")
    died: Said = (1.5, "world", RobotDied(robot=1, silent_since_s=1.2))
    assert broken(run(without=cut)) == [("S4", 1)]
    assert broken(run(died, without=cut)) == []


def test_a_plan_that_promises_nothing_is_not_excused_by_a_death() -> None:
    died: Said = (9.0, "world", RobotDied(robot=1, silent_since_s=8.0))
    assert broken(run(died, plan_1=(0.9, "r1", plan(None)))) == [("S4", 1)]
    again: Said = (0.95, "r1", plan(LEFT_M))
    assert broken(run(died, again, plan_1=(0.9, "r1", plan(None)))) == [], "the greatest promise counts"


def test_a_step_is_judged_up_to_where_the_next_order_was_taken_on_its_way() -> None:
    cut = ("there 1", "end 1", "finished 1", "goal 1", "arrived 1", "arrived 2", "arrived 3")
    turned: Said = (2.9, "world", replace(order(1, 0.9, 0.9, step=2), number=2))
    assert broken(run(turned, plan_1=(0.9, "r1", plan(0.6)), without=cut)) == [("S4", 1), ("S4", 1)]


def test_a_promise_is_kept_until_its_step_is_over_however_many_follow() -> None:
    """Where obstacles move, a leader plans and gives up, and its body takes no order."""
    others = [(2.1, "r1", replace(plan(LEFT_M), step=step)) for step in range(2, 12)]
    inflated = run(*others, plan_1=(0.9, "r1", plan(LEFT_M + INFLATED_M)))
    assert broken(inflated) == [("S4", 1)]


def test_a_law_that_promises_nothing_is_not_judged() -> None:
    printed = replace(SCENE, law=replace(SCENE.law, law="printed"))
    assert breaches(promised(None), printed) == []
