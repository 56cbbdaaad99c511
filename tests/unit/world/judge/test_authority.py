"""S3 from the timeline alone: two robots on a straight path, robot 2 at its start, robot 1 at 0.6 m."""

from collections.abc import Sequence

import pytest

from protocol.frames import Point
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    OrderAccepted,
    PoseSampled,
    PromiseBroken,
    Record,
    RobotDied,
    StepPlanned,
    StrandFormed,
    StrandReversed,
)
from tests.support.stages.world_stage import planned
from world.judge.authority import Tolerance, judge_authority
from world.judge.evidence import Evidence

Line = tuple[str, float, Record]

FORMED = StrandFormed(epoch=1, sensed=True, order=(1, 2), path_length_m=0.6)
EXACT = Tolerance(mu0_m=0.01, heading_error_rad=0.0, speed_mps_max=1.0)


def pose(robot: int, x_m: float, y_m: float = 0.0) -> PoseSampled:
    return PoseSampled(robot=robot, x_m=x_m, y_m=y_m, heading_rad=0.0)


def order(
    robot: int, x_m: float, to_x_m: float | None, *, step: int = 0, epoch: int = 1, to_y_m: float = 0.0
) -> OrderAccepted:
    """An order along the x axis; arc length is x + 0.6 m, since robot 2 starts at x = -0.6 m."""
    return OrderAccepted(
        robot=robot,
        number=1,
        epoch=epoch,
        step=step,
        x_m=x_m,
        y_m=0.0,
        target=None if to_x_m is None else Point(x_m=to_x_m, y_m=to_y_m),
        reach_m=0.0 if to_x_m is None else to_x_m + 0.6,
    )


def grant(authority_m: float, *, to: int = 2, epoch: int = 1) -> AuthorityGranted:
    return AuthorityGranted(to=to, epoch=epoch, authority_m=authority_m)


def plan(to_x_m: float, *, step: int = 1, epoch: int = 1) -> StepPlanned:
    return planned(Point(x_m=to_x_m, y_m=0.0), step=step, epoch=epoch, reach_m=to_x_m + 0.6)


START: list[Line] = [
    ("world", 0.0, pose(1, 0.0)),
    ("world", 0.0, pose(2, -0.6)),
    ("r1", 0.1, FORMED),
    ("r2", 0.1, FORMED),
]
LED: list[Line] = [
    ("r1", 0.2, plan(1.0)),
    ("world", 0.22, order(1, 0.0, 1.0, step=1)),
    ("world", 0.22, pose(1, 0.0)),
    ("world", 2.22, pose(1, 1.0)),
]
FOLLOWED: list[Line] = [
    ("r1", 2.3, grant(0.8)),
    ("world", 2.32, order(2, -0.6, 0.2)),
    ("world", 2.32, pose(2, -0.6)),
    ("world", 3.92, pose(2, 0.2)),
]


def judge(lines: Sequence[Line], tolerance: Tolerance = EXACT) -> list[PromiseBroken]:
    evidence = Evidence()
    for n, (source, t_s, record) in enumerate(lines, start=1):
        evidence.hear(source, Entry(n=n, t_s=t_s, hlc="", record=record))
    return [broken for _, broken in judge_authority(evidence, tolerance)]


def test_a_leader_on_its_plan_and_a_follower_on_its_grant_are_lawful() -> None:
    assert judge(START + LED + FOLLOWED) == []


def test_a_grant_recorded_after_its_order_still_allows_it() -> None:
    granted, *rest = FOLLOWED
    assert judge([*START, *LED, *rest, granted]) == []


RED = {
    "granted too late": [("r1", 2.5, grant(0.8)), *FOLLOWED[1:]],
    "never granted": FOLLOWED[1:],
    "beyond the authority": [("r1", 2.3, grant(0.7)), *FOLLOWED[1:]],
    "granted in another epoch": [("r1", 2.3, grant(0.8, epoch=0)), *FOLLOWED[1:]],
    "granted to another robot": [("r1", 2.3, grant(0.8, to=3)), *FOLLOWED[1:]],
    "granted by itself": [("r2", 2.3, grant(0.8)), *FOLLOWED[1:]],
    "ordered in an epoch without a strand": [FOLLOWED[0], ("world", 2.32, order(2, -0.6, 0.2, epoch=2))],
    "ordered beside the path": [FOLLOWED[0], ("world", 2.32, order(2, -0.6, 0.2, to_y_m=0.05))],
    "moved with no order": [FOLLOWED[0], *FOLLOWED[2:]],
    "moved with the order to stand": [("world", 2.32, order(2, -0.6, None)), *FOLLOWED[2:]],
    "moved before its order": [
        ("world", 2.31, order(2, -0.6, -0.6)),
        *FOLLOWED[:1],
        *FOLLOWED[2:],
        ("world", 4.0, order(2, 0.2, 0.2)),
    ],
    "moved off its line": [*FOLLOWED[:3], ("world", 3.0, pose(2, -0.2, 0.01)), FOLLOWED[3]],
    "moved past its target": [*FOLLOWED, ("world", 4.0, pose(2, 0.3))],
    "moved faster than it can": [*FOLLOWED[:3], (FOLLOWED[3][0], 2.33, FOLLOWED[3][2])],
    "moved backwards": [*FOLLOWED[:3], ("world", 3.0, pose(2, -0.7))],
}


@pytest.mark.parametrize("lines", RED.values(), ids=RED.keys())
def test_each_unlawful_action_of_a_follower_is_one_violation(lines: list[Line]) -> None:
    broken = judge(START + LED + lines)
    assert [(each.invariant, each.robot) for each in broken] == [("S3", 2)]


LED_ASTRAY = {
    "led without a plan": LED[1:],
    "planned too late": [("r1", 0.3, plan(1.0)), *LED[1:]],
    "planned by another robot": [("r2", 0.2, plan(1.0)), *LED[1:]],
    "led to another step's target": [("r1", 0.2, plan(1.0, step=2)), *LED[1:]],
    "led elsewhere than planned": [("r1", 0.2, plan(1.1)), *LED[1:]],
    "led with no step": [LED[0], ("world", 0.22, order(1, 0.0, 1.0)), *LED[2:]],
}


@pytest.mark.parametrize("lines", LED_ASTRAY.values(), ids=LED_ASTRAY.keys())
def test_a_leader_drives_only_the_steps_that_it_planned(lines: list[Line]) -> None:
    assert [(each.invariant, each.robot) for each in judge(START + lines)] == [("S3", 1)]


def test_a_robot_cannot_forge_entries_of_the_world() -> None:
    forged: list[Line] = [("r2", t_s, record) for _, t_s, record in FOLLOWED[1:]]
    assert judge([*START, *LED, *forged]) == []  # none of it has happened


def test_a_deviation_within_the_drive_error_is_allowed() -> None:
    beside: list[Line] = [*FOLLOWED[:3], ("world", 3.92, pose(2, 0.2, 0.008))]
    assert (
        judge(START + LED + beside, Tolerance(mu0_m=0.01, heading_error_rad=0.011, speed_mps_max=1.0)) == []
    )
    assert (
        len(judge(START + LED + beside, Tolerance(mu0_m=0.01, heading_error_rad=0.009, speed_mps_max=1.0)))
        == 1
    )


def test_unrecorded_grants_of_a_dead_robot_excuse_the_robot_behind() -> None:
    died: Line = ("world", 9.0, RobotDied(robot=1, silent_since_s=2.3))
    assert judge([*START, *LED, *FOLLOWED[1:], died]) == []


def test_an_order_renewed_during_a_drive_is_one_drive() -> None:
    renewed: list[Line] = [
        ("world", 2.62, order(2, -0.45, 0.2)),
        ("world", 2.62, pose(2, -0.45)),
    ]
    assert judge([*START, *LED, *FOLLOWED[:3], *renewed, FOLLOWED[3]]) == []


def test_a_reduced_grant_within_an_epoch_is_a_violation() -> None:
    shrunk: list[Line] = [("r1", 3.0, grant(0.3)), ("r1", 3.1, grant(0.2))]
    assert [(each.invariant, each.robot) for each in judge([*START, *shrunk])] == [("S3", 1)]
    anew: list[Line] = [("r1", 3.0, grant(0.3)), ("r1", 3.1, grant(0.2, epoch=2))]
    assert judge([*START, *anew]) == []


# --- reversed ---------------------------------------------------------------------------------------
#
# Robot 1 stands at x = 1 m, robot 2 at x = 0.2 m. From there robot 2 leads back to x = -0.6 m, where it
# began: in epoch 2, arc length is 1 m - x.

BACK = StrandFormed(epoch=2, sensed=False, order=(2, 1), path_length_m=1.6)
REVERSED = StrandReversed(epoch=1, cut_m=0.0, end_m=1.6, back_by_m=0.5)


def back(robot: int, x_m: float, to_x_m: float, *, epoch: int = 2, beside_m: float = 0.0) -> OrderAccepted:
    """An order in the opposite direction."""
    return OrderAccepted(
        robot=robot,
        number=2,
        epoch=epoch,
        step=0,
        x_m=x_m,
        y_m=0.0,
        target=Point(x_m=to_x_m, y_m=beside_m),
        reach_m=1.0 - to_x_m,
    )


TURNED: list[Line] = [
    ("r1", 4.0, REVERSED),
    ("r2", 4.1, BACK),
    ("r1", 4.2, BACK),
]
LED_BACK: list[Line] = [
    ("world", 4.12, back(2, 0.2, -0.6)),
    ("world", 4.12, pose(2, 0.2)),
    ("world", 5.72, pose(2, -0.6)),
]
FOLLOWED_BACK: list[Line] = [
    ("r2", 5.8, grant(1.2, to=1, epoch=2)),
    ("world", 5.82, back(1, 1.0, -0.2)),
    ("world", 5.82, pose(1, 1.0)),
    ("world", 7.82, pose(1, -0.2)),
]


def test_a_reversed_strand_may_drive_back_along_its_old_path() -> None:
    assert judge(START + LED + FOLLOWED + TURNED + LED_BACK + FOLLOWED_BACK) == []


def test_the_new_leader_continues_with_its_own_steps_from_the_cut_of_the_path() -> None:
    cut = StrandReversed(epoch=1, cut_m=0.8, end_m=1.6, back_by_m=0.0)
    step = planned(Point(x_m=0.2, y_m=0.5), step=1, epoch=2, reach_m=1.3)
    led = OrderAccepted(
        robot=2, number=2, epoch=2, step=1, x_m=0.2, y_m=0.0, target=Point(x_m=0.2, y_m=0.5), reach_m=1.3
    )
    steps: list[Line] = [("r2", 4.11, step), ("world", 4.12, led)]
    ahead: list[Line] = [("r2", 5.0, grant(1.0, to=1, epoch=2)), ("world", 5.02, _round_the_corner())]
    assert judge([*START, *LED, *FOLLOWED, ("r1", 4.0, cut), *TURNED[1:], *steps, *ahead]) == []
    uncut: list[Line] = [*TURNED, *steps, *ahead]
    assert [(each.invariant, each.robot) for each in judge(START + LED + FOLLOWED + uncut)] == [("S3", 1)]


def _round_the_corner() -> OrderAccepted:
    """Robot 1, to a place 0.2 m above the corner where robot 2 stood when it became leader."""
    corner = Point(x_m=0.2, y_m=0.2)
    return OrderAccepted(robot=1, number=2, epoch=2, step=0, x_m=1.0, y_m=0.0, target=corner, reach_m=1.0)


ASTRAY_BACK: dict[str, list[Line]] = {
    "beyond what there is of the path": [("world", 4.12, back(2, 0.2, -0.7))],
    "beside the path": [("world", 4.12, back(2, 0.2, -0.6, beside_m=0.05))],
    "in an epoch that nobody reversed into": [("world", 4.12, back(2, 0.2, -0.6, epoch=3))],
    "in the epoch before": [("world", 4.12, back(2, 0.2, -0.6, epoch=1))],
    "a step that it did not plan": [("world", 4.12, order(2, 0.2, -0.6, step=1, epoch=2))],
}


@pytest.mark.parametrize("lines", ASTRAY_BACK.values(), ids=ASTRAY_BACK.keys())
def test_the_new_leader_may_drive_back_only_along_the_old_path(lines: list[Line]) -> None:
    broken = judge(START + LED + FOLLOWED + TURNED + lines)
    assert [(each.invariant, each.robot) for each in broken] == [("S3", 2)]


WRONG_WAY: dict[str, list[Line]] = {
    "nobody reversed": TURNED[1:],
    "another epoch was reversed": [("r1", 4.0, StrandReversed(epoch=2, cut_m=0.0, end_m=1.6, back_by_m=0.5))],
    "reversed from elsewhere": [("r1", 4.0, StrandReversed(epoch=1, cut_m=0.0, end_m=1.4, back_by_m=0.5))],
    "the path was cut": [("r1", 4.0, StrandReversed(epoch=1, cut_m=0.2, end_m=1.6, back_by_m=0.0))],
}


@pytest.mark.parametrize("lines", WRONG_WAY.values(), ids=WRONG_WAY.keys())
def test_an_order_along_a_path_that_is_not_the_old_one_reversed_is_a_violation(lines: list[Line]) -> None:
    broken = judge(START + LED + FOLLOWED + lines + TURNED[1:] + LED_BACK[:1])
    assert [(each.invariant, each.robot) for each in broken] == [("S3", 2)]


def test_a_grant_of_the_old_epoch_allows_nothing_in_the_new_one() -> None:
    stale: list[Line] = [("r2", 5.8, grant(1.2, to=1, epoch=1)), *FOLLOWED_BACK[1:]]
    broken = judge(START + LED + FOLLOWED + TURNED + LED_BACK + stale)
    assert [(each.invariant, each.robot) for each in broken] == [("S3", 1)]


def test_a_strand_recorded_by_a_foreign_robot_does_not_bind_others() -> None:
    others: list[Line] = [("r2", 4.1, BACK)]
    broken = judge([*START, *LED, *FOLLOWED, TURNED[0], *others, *LED_BACK, *FOLLOWED_BACK])
    assert [(each.invariant, each.robot) for each in broken] == [("S3", 1)]


def test_an_order_in_a_strand_without_poses_is_a_violation_and_no_crash() -> None:
    evidence = Evidence()
    for n, (source, t_s, record) in enumerate([START[2], LED[1]], start=1):
        evidence.hear(source, Entry(n=n, t_s=t_s, hlc="", record=record))
    assert not any(evidence.poses[robot] for robot in FORMED.order), "asked for, and not there"
    assert [broken.invariant for _, broken in judge_authority(evidence, EXACT)] == ["S3"]
