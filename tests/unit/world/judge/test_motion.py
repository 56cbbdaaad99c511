"""S3, F1 and F3 by the motion of bodies."""

import pytest
from msgspec.structs import replace

from protocol.fence import Cause, May
from tests.support.histories.entries import Said
from tests.support.histories.fenced import (
    FIRST,
    SECOND,
    breaches,
    broken,
    fence,
    formation,
    order,
    plan,
    pose,
    run,
    scan,
)
from world.judge.rules.motion import Tolerance

ORDER_2 = order(2, (-0.6, 0.0), (-0.2, 0.0), reach_m=1.0)
OFF_COURSE: dict[str, list[Said]] = {
    "no order": run(without=("order 2",)),
    "an order to stand": run(order_2=(2.92, "world", replace(ORDER_2, target=None))),
    "an order to stand from before": run(
        order_2=(2.92, "world", replace(ORDER_2, target=None, epoch=0, turn=0, life=""))
    ),
    "before its order": run(order_2=(3.0, "world", replace(ORDER_2, x_m=-0.56))),
    "off its line": run((3.3, "world", pose(2, -0.4, 0.01))),
    "past its target": run((3.9, "world", pose(2, -0.1))),
    "backwards": run((3.3, "world", pose(2, -0.7))),
    "back along its line": run((3.3, "world", pose(2, -0.4)), (3.4, "world", pose(2, -0.45))),
    "back from its target": run((3.9, "world", pose(2, -0.3))),
    "too fast": run(there_2=(3.0, "world", pose(2, -0.2))),
}


@pytest.mark.parametrize("said", OFF_COURSE.values(), ids=OFF_COURSE.keys())
def test_a_body_moves_only_by_an_order_along_its_line_and_no_faster_than_allowed(said: list[Said]) -> None:
    assert broken(said) == ["S3"]


def test_a_deviation_within_the_drive_error_is_allowed() -> None:
    beside: Said = (3.72, "world", pose(2, -0.2, 0.004))
    assert broken(run(there_2=beside), inexact(0.011)) == []
    assert broken(run(there_2=beside), inexact(0.009)) == ["S3"]


def inexact(heading_error_rad: float) -> Tolerance:
    return Tolerance(mu0_m=0.01, heading_error_rad=heading_error_rad, speed_mps_max=1.0)


def test_an_order_renewed_during_a_drive_is_one_drive() -> None:
    renewed = replace(ORDER_2, x_m=-0.4, y_m=0.003)
    more: list[Said] = [
        (3.32, "world", pose(2, -0.4, 0.003)),
        (3.32, "world", renewed),
        (3.4, "world", pose(2, -0.36, -0.003)),
    ]
    assert broken(run(*more), inexact(0.011)) == []


def test_a_drive_begins_anew_with_a_new_target_or_a_new_fence() -> None:
    corner = order(3, (-1.0, 0.5), (-1.0, 0.0), turn=1)
    more: list[Said] = [
        (0.55, "r3", plan(-1.0, joins=True)),
        (0.6, "world", corner),
        (1.1, "world", pose(3, -1.0)),
        (1.1, "world", order(3, (-1.0, 0.0), (-1.2, 0.0), turn=1)),
    ]
    assert broken(run(*more, without=("order 3",))) == []
    beside: Said = (4.8, "world", pose(1, 0.9, 0.02))
    assert broken(run(beside), inexact(0.03)) == ["S3"], "0.03 of the way from 0.8 m on"


def test_a_motion_that_stays_unlawful_is_one_violation_until_it_is_lawful_again() -> None:
    astray: list[Said] = [(3.1, "world", pose(2, -0.5, 0.1)), (3.2, "world", pose(2, -0.45, 0.1))]
    assert broken(run(*astray)) == ["S3"]
    again: list[Said] = [
        (3.3, "world", pose(2, -0.4)),
        (3.4, "world", pose(2, -0.35)),
        (3.5, "world", pose(2, -0.3, 0.1)),
    ]
    assert broken(run(*astray, *again)) == ["S3", "S3"]


# --- F1: orders end with their fence ------------------------------------------------------------------------


def test_a_body_stands_after_a_change_of_fence_until_it_takes_a_new_order() -> None:
    """Robot 1 is on the line of its old order, and ALL lets it move: only the fence of the order is wrong."""
    assert broken(run(without=("order 1 again",))) == ["F1"]


def test_a_body_that_moves_on_through_a_change_of_fence_is_found() -> None:
    on: Said = (4.1, "world", pose(1, 0.9))
    assert broken(run(on, without=("there 1", "drive 1 again", "there 1 again", "order 1 again"))) == [
        "F1",
        "F3",
    ]


def test_a_body_that_stops_a_fiftieth_of_a_second_after_a_change_of_fence_is_found() -> None:
    assert broken(run(there_1=(3.94, "world", pose(1, 0.8)))) == ["F1", "F3"]


# --- F3: who moves ------------------------------------------------------------------------------------------

PUSHED: dict[str, list[Said]] = {
    "in the turn of another": [(0.7, "world", pose(2, -0.6)), (0.8, "world", pose(2, -0.61))],
    "in a turn of nobody": [(1.85, "world", pose(2, -0.6)), (1.9, "world", pose(2, -0.61))],
    "before the first view": [(0.05, "world", pose(2, -0.6)), (0.1, "world", pose(2, -0.61))],
}


@pytest.mark.parametrize("more", PUSHED.values(), ids=PUSHED.keys())
def test_a_body_that_moves_out_of_turn_is_found_by_its_motion_alone(more: list[Said]) -> None:
    without = ("order 2", "drive 2", "there 2")
    still = run(*more, without=without, formed=(1.9, "r2", formation(FIRST, 3, 1.2, 0.59, 0.0)))
    assert broken(still) == ["F3", "S3"]


def test_nobody_moves_while_the_operator_has_stopped_all() -> None:
    stop = replace(fence(20_000, 0, May.STOPPED, cause=Cause.OPERATOR), coordinator=0)
    stopped = run(
        raised_again=(3.92, "world", stop),
        all_again=(3.95, "world", fence(30_003, 0, cause=Cause.PLEA)),
        there_1=(3.93, "world", pose(1, 0.8)),
        without=(
            *("formed again", "joined 1 again", "plan 1 again"),
            *("order 1 again", "drive 1 again", "there 1 again"),
        ),
    )
    whys = {breach.invariant: breach.why for _, breach in breaches(stopped)}
    assert whys.keys() == {"F1", "F3"}, "moved on, and a view was proposed over the stop"
    assert "nobody may move" in " ".join(breach.why for _, breach in breaches(stopped))


def test_a_body_of_no_member_stands_while_the_strand_drives() -> None:
    beside = order(4, (5.0, 5.0), (5.0, 6.0))
    drives: list[Said] = [
        (0.0, "world", pose(4, 5.0, 5.0)),
        (2.4, "world", scan(4)),
        (2.5, "world", beside),
        (2.5, "world", pose(4, 5.0, 5.0)),
        (3.5, "world", pose(4, 5.0, 6.0)),
    ]
    assert broken(run(*drives)) == ["F3", "F5"]


def test_a_violation_names_the_fence_of_the_order_and_the_one_in_force() -> None:
    moved = run(without=("order 1 again",))
    ((t_s, breach),) = breaches(moved)
    assert (t_s, breach.robot) == (5.02, 1)
    assert breach.why == f"moved by an order of turn 3 of epoch {FIRST} in turn 1 of epoch {SECOND}"
    assert breach.measured_m == pytest.approx(0.2)


def test_bodies_that_stand_are_sampled_and_lawful() -> None:
    samples: list[Said] = [(t_s, "world", pose(2, -0.6)) for t_s in (0.5, 1.5, 1.8, 2.0, 2.5)]
    assert broken(run(*samples)) == []
