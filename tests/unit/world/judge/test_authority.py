"""F1, F2, F5, F6 and S3 by the orders that bodies accept: each rule is kept, and each is seen broken."""

from collections.abc import Sequence

import pytest
from msgspec.structs import replace

from protocol.fence import May
from protocol.frames import Point
from protocol.timeline import OrderAccepted, RobotDied, StepAbandoned, StrandFormed
from tests.support.histories.entries import Said
from tests.support.histories.fenced import (
    FIRST,
    SECOND,
    breaches,
    broken,
    fence,
    formation,
    grant,
    order,
    plan,
    pose,
    run,
    scan,
)

STILL_2 = ("order 2", "drive 2", "there 2")
STILL_3 = ("order 3", "drive 3", "there 3")
OF_2 = order(2, (-0.6, 0.0), (-0.2, 0.0), reach_m=1.0)
OF_3 = order(3, (-1.0, 0.5), (-1.2, 0.0), turn=1)


def accepted(t_s: float, order: OrderAccepted) -> Said:
    return t_s, "world", order


UNBORNE: dict[str, tuple[str, Said]] = {
    "an older turn": ("F1", accepted(1.7, replace(OF_3, turn=0))),
    "an older epoch": ("F1", accepted(4.9, OF_2)),
    "an older epoch of the same generation": ("F1", accepted(1.7, replace(OF_3, epoch=10_001))),
    "another life": ("F1", accepted(1.7, replace(OF_3, life="ff"))),
    "a robot that the fence does not name": ("F1", accepted(1.7, replace(OF_2, turn=1))),
    "a turn of nobody": ("F1", accepted(1.85, replace(OF_3, turn=2))),
    "a newer turn": ("F2", accepted(1.7, replace(OF_3, turn=2))),
    "a newer epoch": ("F2", accepted(1.7, replace(OF_3, epoch=SECOND, turn=0))),
    "a newer epoch of the same generation": ("F2", accepted(1.7, replace(OF_3, epoch=10_003))),
}


@pytest.mark.parametrize(("invariant", "said"), UNBORNE.values(), ids=UNBORNE.keys())
def test_an_order_that_does_not_bear_its_fence_is_a_violation(invariant: str, said: Said) -> None:
    assert broken(run(said)) == [invariant]


def test_an_order_to_stand_needs_no_fence() -> None:
    stand = order(1, (0.0, 0.0), None, epoch=0, turn=0, life="")
    assert broken(run(accepted(1.9, stand), accepted(4.45, stand))) == []


UNSEEN: dict[str, list[Said]] = {
    "never scanned": run(without=("scan 3",)),
    "scanned before its turn": run(scan_3=(0.3, "world", scan(3))),
    "scanned before ALL": run(scan_2=(1.9, "world", scan(2))),
    "scanned in turn 0, where ALL is turn 3": run(scan_2=(0.25, "world", scan(2))),
    "scanned in turn 0, where ALL is turn 1": run(scan_1_again=(4.0, "world", scan(1))),
    "another body was scanned": run(scan_2=(2.4, "world", scan(3))),
    "the leader, in the epoch before": run(without=("scan 1 again",)),
}


@pytest.mark.parametrize("said", UNSEEN.values(), ids=UNSEEN.keys())
def test_an_order_without_a_scan_under_its_fence_is_a_violation(said: list[Said]) -> None:
    assert broken(said) == ["F6"]


def test_followers_need_no_scan_under_a_law_that_promises_nothing() -> None:
    assert broken(run(without=("scan 2",)), followers_sense=False) == []
    assert broken(run(without=("scan 1",)), followers_sense=False) == ["F6"]
    assert broken(run(without=("scan 3",)), followers_sense=False) == ["F6"]


JOINED_ASTRAY: dict[str, list[Said]] = {
    "nothing planned": run(without=("plan 3",)),
    "planned too late": run(plan_3=(0.7, "r3", plan(-1.2, joins=True))),
    "planned elsewhere": run(plan_3=(0.55, "r3", plan(-1.3, joins=True))),
    "planned by another": run(plan_3=(0.55, "r2", plan(-1.2, joins=True))),
    "planned in another epoch": run(plan_3=(0.0, "r3", plan(-1.2, joins=True, epoch=0))),
    "planned as a leader's step": run(plan_3=(0.55, "r3", plan(-1.2))),
}


@pytest.mark.parametrize("said", JOINED_ASTRAY.values(), ids=JOINED_ASTRAY.keys())
def test_a_robot_that_joins_goes_only_where_it_planned_to(said: list[Said]) -> None:
    assert [each for each in broken(said) if each != "P1"] == ["S3"]


def died(robot: int, t_s: float = 9.0) -> Said:
    return t_s, "world", RobotDied(robot=robot, silent_since_s=0.0)


def test_the_last_steps_of_a_robot_that_was_killed_may_be_missing() -> None:
    after_3 = ("rank 3", "proposed again", "formed again", "all again", "order 1 again", "drive 1 again")
    quiet = (*after_3, "there 1 again", "plan 1 again")
    assert broken(run(died(3), without=("plan 3", *quiet))) == []
    assert broken(run(died(2), without=("plan 3", *quiet))) == ["S3"]
    assert broken(run(died(1, 5.5), without=("plan 1 again",))) == []
    assert broken(run(died(1, 4.61), without=("plan 1 again",))) == ["F5"]


FOLLOWED_ASTRAY: dict[str, list[Said]] = {
    "granted too late": run(grant_2=(3.0, "r1", grant(1.0))),
    "never granted": run(without=("grant 2",)),
    "beyond its authority": run(grant_2=(2.9, "r1", grant(0.9))),
    "beside the path": run(
        order_2=accepted(2.92, replace(OF_2, target=Point(x_m=-0.2, y_m=0.05))), without=STILL_2[1:]
    ),
    "at another arc length": run(order_2=accepted(2.92, replace(OF_2, reach_m=0.9))),
}


@pytest.mark.parametrize("said", FOLLOWED_ASTRAY.values(), ids=FOLLOWED_ASTRAY.keys())
def test_a_follower_goes_only_along_the_path_and_as_far_as_was_granted(said: list[Said]) -> None:
    assert broken(said) == ["F5"]


def test_a_grant_in_another_epoch_or_to_another_robot_allows_nothing() -> None:
    assert broken(run(grant_2=(2.9, "r1", grant(1.0, to=3)))) == ["F5", "F5"], "the grant, and the order"
    assert broken(run(grant_2=(2.9, "r1", grant(1.0, epoch=0)))) == ["F5", "F5", "P2"]
    assert broken(run(grant_2=(2.9, "r2", grant(1.0)))) == ["F5", "F5"]


def test_a_grant_recorded_after_its_order_still_allows_it() -> None:
    assert broken(sorted(run(), key=lambda said: said[1] == "r1")) == []


def test_a_formation_recorded_late_does_not_hide_what_was_granted_before() -> None:
    """As after a crash of the world, when the batches of the robots come in any order."""
    stand = order(3, (-1.2, 0.0), None)
    more = ((2.93, "r1", grant(1.01)), accepted(2.94, stand), (2.95, "r1", grant(1.02)))
    said = run(*more)
    late = [each for each in said if each[1] == "r2" and each[0] > 1.8]
    there = next(at for at, each in enumerate(said) if each[0] > 2.95)
    rest = [each for each in said if each not in late]
    assert broken(said) == []
    assert broken([*rest[: there - len(late)], *late, *rest[there - len(late) :]]) == []


def test_the_last_grants_of_a_robot_that_was_killed_may_be_missing() -> None:
    without = ("grant 2", "joined 1 again", "plan 1 again", "order 1 again", "drive 1 again", "there 1 again")
    assert broken(run(died(1), without=without)) == []
    assert broken(run(died(1, 2.5), without=without)) == ["F5"], "it died before"
    assert broken(run(died(3), without=without)) == ["F5"], "another died"


LED_ASTRAY: dict[str, list[Said]] = {
    "without a plan": run(without=("plan 1",)),
    "planned too late": run(plan_1=(2.4, "r1", plan(1.0))),
    "to the target of another step": run(plan_1=(2.3, "r1", plan(1.0, step=2))),
    "elsewhere than planned": run(plan_1=(2.3, "r1", plan(1.1))),
    "to where it wanted to join": run(plan_1=(2.3, "r1", plan(1.0, joins=True))),
    "further than the formation laid": run(
        order_1=accepted(2.32, order(1, (0.0, 0.0), (1.0, 0.0), reach_m=2.2))
    ),
}


@pytest.mark.parametrize("said", LED_ASTRAY.values(), ids=LED_ASTRAY.keys())
def test_a_leader_drives_only_the_steps_that_it_planned(said: list[Said]) -> None:
    assert broken(said) == ["F5"]


def test_a_follower_that_plans_a_step_of_its_own_is_judged_as_a_follower() -> None:
    beside = accepted(2.92, replace(OF_2, step=1, target=Point(x_m=-0.6, y_m=0.4), reach_m=0.6))
    more: Said = (2.91, "r2", plan(-0.6, 0.4))
    assert broken(run(more, order_2=beside, without=STILL_2[1:])) == ["F5", "P1"]


def test_ground_of_unrecorded_steps_of_a_leader_that_was_killed_may_be_driven() -> None:
    """Robot 3 is granted ground by robot 2, beyond the path that robot 1 recorded."""
    last_words = ("plan 1", "grant 2", "joined 1 again", "plan 1 again")
    without = (*last_words, *STILL_2, "order 1 again", "drive 1 again", "there 1 again")
    more: list[Said] = [
        (3.0, "world", scan(3)),
        (3.7, "r2", grant(1.6, to=3)),
        accepted(3.8, order(3, (-1.2, 0.0), (0.4, 0.0), reach_m=1.6)),
    ]
    assert broken(run(died(1), *more, without=without)) == []
    assert broken(run(*more, without=without)) == ["F5", "F5"], "the leader's order, and robot 3's"


def test_a_violation_says_whether_anything_was_planned() -> None:
    ((_, missing),) = breaches(run(without=("plan 1",)))
    ((_, elsewhere),) = breaches(run(plan_1=(2.3, "r1", plan(1.1))))
    assert (missing.why, missing.measured_m) == ("ordered step 1 that was not planned", None)
    assert elsewhere.why == "ordered elsewhere than step 1 was planned"
    assert elsewhere.measured_m == pytest.approx(0.1)


def test_an_order_in_a_strand_without_a_path_is_a_violation_and_no_crash() -> None:
    pathless = replace(formation(FIRST, 3, 1.2, 0.6, 0.0), laid=())
    assert broken(run(formed=(1.9, "r2", pathless))) == ["F5", "P3"]


def test_an_order_of_no_member_is_a_violation() -> None:
    beside = order(4, (5.0, 5.0), (5.0, 6.0))
    placed: list[Said] = [(0.0, "world", pose(4, 5.0, 5.0)), (2.4, "world", scan(4))]
    assert broken(run(*placed, accepted(2.5, beside))) == ["F5"]


def test_a_path_goes_on_from_where_a_step_was_abandoned() -> None:
    corner = Point(x_m=0.5, y_m=0.5)
    more: list[Said] = [
        (3.0, "r1", StepAbandoned(step=1, epoch=FIRST, x_m=0.5, y_m=0.0)),
        (3.1, "r1", plan(0.5, 1.0, step=2)),
        (3.7, "r1", grant(2.2)),
        accepted(3.8, replace(OF_2, x_m=-0.2, target=corner, reach_m=2.2)),
    ]
    still = ("drive 1", "there 1", "order 1 again", "drive 1 again", "there 1 again")
    assert broken(run(*more, without=still)) == []
    assert broken(run(*more[1:], without=still)) == ["F5"], "the path goes on to 1.0 m"


# --- a strand that has turned round: robot 3 leads back along the path ------------------------------------

BACK: StrandFormed = replace(
    formation(SECOND, 1, 0.8, 0.4, 0.0, order=(3, 2, 1)),
    laid=(Point(x_m=0.8, y_m=0.0), Point(x_m=-0.4, y_m=0.0), Point(x_m=-1.2, y_m=0.0)),
    places_m=(2.0, 1.0, 0.0),
    back_by_m=0.4,
)


def back(to_x_m: float, *, beside_m: float = 0.0) -> Sequence[Said]:
    """Robot 3 leads back, beyond its place, along a path of 2.4 m."""
    target = Point(x_m=to_x_m, y_m=beside_m)
    drive = order(3, (-1.2, 0.0), (0.0, 0.0), epoch=SECOND, turn=1, reach_m=0.8 - to_x_m)
    return (4.52, "world", scan(3)), accepted(4.6, replace(drive, target=target))


def turned(*more: Said) -> list[Said]:
    longer = replace(BACK, laid=(*BACK.laid, Point(x_m=-1.6, y_m=0.0)))
    return run(
        *more,
        formed_again=(4.4, "r3", longer),
        all_again=(4.5, "world", fence(SECOND, 1, May.ALL, named=3, members=3)),
        without=("plan 1 again", "order 1 again", "drive 1 again", "there 1 again"),
    )


def test_a_strand_that_has_turned_round_may_drive_back_along_its_old_path() -> None:
    assert broken(turned(*back(-1.5))) == []
    follows = order(2, (-0.2, 0.0), (-0.8, 0.0), epoch=SECOND, turn=1, reach_m=1.6)
    more: list[Said] = [
        (4.52, "world", scan(2)),
        (4.7, "r3", grant(1.6, epoch=SECOND)),
        accepted(4.8, follows),
        (4.8, "world", pose(2, -0.2)),
        (5.4, "world", pose(2, -0.8)),
    ]
    assert broken(turned(*more)) == []


def test_the_new_leader_may_drive_back_only_as_far_as_the_path_goes() -> None:
    assert broken(turned(*back(-1.7))) == ["F5"]
    assert broken(turned(*back(-1.5, beside_m=0.05))) == ["F5"]


def test_the_new_leader_goes_on_with_its_own_steps_from_the_end_of_the_path() -> None:
    step = order(3, (-1.2, 0.0), (-1.6, 0.5), epoch=SECOND, turn=1, step=1, reach_m=2.9)
    after: list[Said] = [
        (4.52, "world", scan(3)),
        (4.55, "r3", plan(-1.6, 0.5, epoch=SECOND)),
        accepted(4.6, step),
        (4.7, "r3", grant(2.9, epoch=SECOND)),
        (4.52, "world", scan(2)),
        accepted(4.8, order(2, (-0.2, 0.0), (-1.6, 0.5), epoch=SECOND, turn=1, reach_m=2.9)),
    ]
    assert broken(turned(*after)) == []


def test_a_log_that_is_cut_off_is_not_called_broken_for_entries_of_robots_that_come_late() -> None:
    late_s = 0.5
    lines = sorted(run(), key=lambda said: said[0] + (0.0 if said[1] == "world" else late_s))
    assert breaches(lines) == []
    cuts = [lines[:cut] for cut in range(1, len(lines))]
    assert any(breaches(cut) for cut in cuts), "the cuts are between orders and what allows them"
    assert all(breaches(cut, cut_off=True) == [] for cut in cuts)


def test_no_entry_of_a_robot_can_forge_one_of_the_world() -> None:
    forged = (1.7, "r3", OF_2)
    assert broken(run(forged)) == []


def test_a_violation_names_robot_lengths_and_reason() -> None:
    ((t_s, breach),) = breaches(run(grant_2=(2.9, "r1", grant(0.9))))
    assert (t_s, breach.robot, breach.measured_m, breach.required_m) == (2.92, 2, 1.0, 0.9)
    assert breach.why == "ordered further than robot 1 granted"
