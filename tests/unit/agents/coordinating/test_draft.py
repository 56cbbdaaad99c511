"""The strand that a coordinator drafts: each rule of `agents.coordinating.draft`."""

from collections.abc import Callable

import pytest

from agents.coordinating.draft import Draft, NoTurn
from protocol.fence import Cause, Epoch
from protocol.frames import Point, Pose
from protocol.wire.view import Former, Look, Report
from tests.support.stages.one_step import under

GOAL = Point(x_m=9.0, y_m=0.0)
EPOCH, BEFORE = Epoch(generation=2, robot=1, life=5), Epoch(generation=1, robot=1, life=5)
QUEUE = {1: (3.0, 0.0), 2: (2.0, 0.0), 3: (1.0, 0.0), 4: (0.0, 0.0)}
NEAREST_M = 0.25  # two radii and the separation: the least distance for which ground is granted, less mu0
Reports = dict[int, Report]
Places = dict[int, tuple[float, float]]


def drafted(*, robots: int = 4, cause: Cause = Cause.NEIGHBOUR_LOST, led: tuple[int, ...] = ()) -> Draft:
    mission = under("certified", robots=robots, robot_radius_m=0.1, goal=GOAL, goal_tolerance_m=0.1)
    return Draft(mission, cause, led)


def reports(places: Places, former: Epoch | None = None, *stayed: int) -> Reports:
    """All have reported; these have stayed in a former strand, in this order."""
    made: Reports = {}
    for robot, (x_m, y_m) in places.items():
        rank = stayed.index(robot) if robot in stayed else None
        formers = () if former is None or rank is None else (Former(epoch=former, rank=rank, s_m=9.0 - rank),)
        place = Pose(x_m=x_m, y_m=y_m, heading_rad=0.0)
        made[robot] = Report(epoch=EPOCH, life=robot, number=1, turn=0, place=place, formers=formers)
    return made


def sees(*clear: int, driven: tuple[int, ...] = ()) -> Callable[[int], Look]:
    """What robots see of their legs."""
    straight = (Point(x_m=0.0, y_m=0.0),) * 2  # where it ends does not matter here
    return lambda robot: Look(
        number=1, clear=robot in {*clear, *driven}, way=straight if robot in driven else ()
    )


def settled(draft: Draft, there: Reports, *clear: int, driven: tuple[int, ...] = ()) -> Draft:
    draft.begin(there, {}, ())
    assert draft.settle(there, sees(*clear, driven=driven))
    return draft


# --- rule 1: who is in place ----------------------------------------------------------------------------


def test_the_robot_that_has_the_turn_is_told_which_robots_stand_where_and_not_only_how_many() -> None:
    there = reports({robot: QUEUE[robot] for robot in (1, 2, 4)})
    join = settled(drafted(), there, 2).join(4, there, turn=1)
    assert (len(join.strand), join.waiting, join.robots) == (2, (), (1, 2))
    join = settled(drafted(), there).join(4, there, turn=1)
    assert (len(join.strand), len(join.waiting), join.robots) == (1, 1, (1, 2))


@pytest.mark.parametrize(
    ("clear", "strand"),
    [((2, 3, 4), (1, 2, 3, 4)), ((2, 3), (1, 2, 3)), ((2, 4), (1, 2)), ((3, 4), (1,)), ((), (1,))],
)
def test_in_place_are_those_up_to_the_first_leg_that_is_not_clear(
    clear: tuple[int, ...], strand: tuple[int, ...]
) -> None:
    assert settled(drafted(), reports(QUEUE), *clear).strand == strand


def test_in_place_are_those_up_to_the_first_that_folds_back() -> None:
    folded = reports({1: (3.0, 0.0), 2: (2.0, 0.0), 3: (1.99, 0.5), 4: (3.0, 0.1)})
    assert settled(drafted(), folded, 2, 3, 4).strand != (1, 2, 3, 4)


def hairpin(apart_m: float, *, front_m: float = 0.0) -> Places:
    """Two legs beside each other, and the one between them; the leader may have come back half the way."""
    return {1: (front_m, apart_m), 2: (1.0, apart_m), 3: (1.0, 0.0), 4: (0.0, 0.0)}


def test_robots_whose_legs_were_driven_stay_in_place_though_the_strand_folds_back_by_the_tolerance() -> None:
    there = reports(hairpin(NEAREST_M + 0.001), BEFORE, 1, 2, 3, 4)
    assert settled(drafted(), there, 2, 3, 4).strand == (1, 2)
    assert settled(drafted(), there, driven=(2, 3, 4)).strand == (1, 2, 3, 4)


def test_driven_legs_of_several_strands_that_fold_back_further_are_no_strand() -> None:
    there = reports(hairpin(NEAREST_M - 0.001), BEFORE, 1, 2, 3, 4)
    assert settled(drafted(), there, driven=(2, 3, 4)).strand == (1, 2)


def test_a_robot_that_has_led_leads_again_over_driven_legs_though_the_strand_folds_back() -> None:
    there = reports(hairpin(NEAREST_M + 0.001, front_m=0.6), BEFORE, 2, 3, 4)
    assert settled(drafted(), there, driven=(2, 3, 4)).strand == (1, 2, 3, 4)


def test_a_robot_that_came_to_a_place_by_a_turn_is_in_place_behind_those() -> None:
    draft = settled(drafted(), reports(QUEUE), 2)
    draft.end_turn(4, placed=True)
    draft.end_turn(3, placed=True)
    assert draft.strand == (1, 2, 4, 3)


def test_places_in_the_newest_strand_or_draft_count_and_older_ones_do_not() -> None:
    there = reports(QUEUE, EPOCH, 3, 4) | {
        robot: report for robot, report in reports(QUEUE, BEFORE, 1, 2).items() if robot in (1, 2)
    }
    draft = drafted()
    draft.begin(there, {}, ())
    assert [robot for robot in draft.order if robot in (3, 4)] == [3, 4]


def test_where_a_strand_has_dissolved_no_places_count() -> None:
    there = reports(QUEUE, BEFORE, 4, 3, 2, 1)
    kept, dissolved = drafted(), drafted(cause=Cause.BLOCKED)
    for draft in (kept, dissolved):
        draft.begin(there, {}, ())
    assert (kept.order, dissolved.order) == ((4, 3, 2, 1), (1, 2, 3, 4))


def test_a_robot_in_front_leads_those_that_have_stayed_only_if_nobody_has_to_move_for_that() -> None:
    there = reports(QUEUE, BEFORE, 2, 3)
    assert settled(drafted(), there, 2, 3, 4, driven=(3,)).strand == (1, 2, 3, 4)
    draft = drafted()
    draft.begin(there, {}, ())
    assert draft.order[:3] == (1, 2, 3)
    assert not draft.settle(there, sees(4, driven=(3,))), "robot 2 does not see its way to robot 1"
    draft.begin(there, {}, ())
    assert draft.order[:2] == (2, 3)


def test_robots_in_place_stay_so_until_another_order_is_settled() -> None:
    there = reports(QUEUE)
    draft = settled(drafted(), there, 2)
    draft.end_turn(4, placed=True)
    draft.end_turn(3, placed=True)
    there |= reports({5: (4.0, 0.0)})
    draft.begin(there, {}, ())
    assert draft.order[0] == 5
    assert draft.strand == (1, 2, 4, 3), "what robots are told while they look"
    assert not draft.settle(there, sees(3, 4, 2)), "robot 1 does not see its way to robot 5"
    draft.begin(there, {}, ())
    assert draft.order == (1, 2, 4, 3, 5)


# --- rule 2: turns --------------------------------------------------------------------------------------


def test_the_turn_goes_to_the_nearest_that_is_not_in_place_and_has_not_had_one_in_vain() -> None:
    there, draft = reports(QUEUE), drafted()
    settled(draft, there, 2)
    assert draft.next(there, others_may_come_back=False) == 3
    draft.end_turn(3, placed=False)
    assert draft.next(there, others_may_come_back=False) == 4


def test_a_draft_that_begins_again_with_the_same_strand_repeats_no_turn_that_was_in_vain() -> None:
    there, draft = reports(QUEUE), drafted()
    settled(draft, there, 2)
    draft.end_turn(3, placed=False)
    settled(draft, there, 2)
    assert draft.next(there, others_may_come_back=False) == 4
    settled(draft, there)
    assert draft.next(there, others_may_come_back=False) == 2, "behind another strand all may try"
    draft.end_turn(2, placed=False)
    assert draft.next(there, others_may_come_back=False) == 3


def test_when_a_robot_comes_to_a_place_all_others_may_have_a_turn_again() -> None:
    there, draft = reports(QUEUE), settled(drafted(), reports(QUEUE), 2)
    draft.end_turn(3, placed=False)
    draft.end_turn(4, placed=True)
    assert draft.next(there, others_may_come_back=False) == 3


def test_of_robots_that_all_had_a_turn_in_vain_the_last_is_the_first_behind_another_strand() -> None:
    """In a queue, only the last has room to move; once it has come in, the one before it has."""
    there = reports(QUEUE)
    draft = settled(drafted(), there)
    for robot in (2, 3):
        assert draft.next(there, others_may_come_back=False) == robot
        draft.end_turn(robot, placed=False)
    draft.end_turn(4, placed=True)
    assert draft.next(there, others_may_come_back=False) == 3


def test_a_draft_is_done_when_all_are_in_place() -> None:
    there = reports(QUEUE)
    draft = settled(drafted(), there, 2, 3, 4)
    assert draft.next(there, others_may_come_back=False) == NoTurn.DONE


# --- rule 3: other leaders ------------------------------------------------------------------------------


def in_vain(draft: Draft, *robots: int) -> Draft:
    for robot in robots:
        draft.end_turn(robot, placed=False)
    return draft


def tried(draft: Draft, there: Reports) -> list[int]:
    """The robots that lead, one after the other, until the draft is done, where all turns are in vain."""
    led = [settled(draft, there).strand[0]]
    for _ in range(200):
        match draft.next(there, others_may_come_back=False):
            case int(robot):
                draft.end_turn(robot, placed=False)
            case NoTurn.BEGIN:
                led.append(settled(draft, there).strand[0])
            case NoTurn.DONE:
                return led
            case NoTurn.WAIT:
                pass
    raise AssertionError("it is never done")


ACROSS = {1: (0.5, 0.0), 2: (0.0, 1.0), 3: (0.0, -1.0)}
"""Robot 1 is the nearest to the goal. A strand has less way to drive if an end leads."""


@pytest.mark.parametrize(("led", "then"), [((), [2, 1]), ((1,), [2]), ((1, 2, 3), [1])])
def test_where_that_is_in_vain_the_nearest_to_the_goal_leads_that_has_not(
    led: tuple[int, ...], then: list[int]
) -> None:
    assert tried(drafted(robots=3, led=led), reports(ACROSS)) == then


@pytest.mark.parametrize("in_place", [(), (2,), (2, 3)])
def test_those_in_place_go_on_at_once_if_nobody_is_nearer_to_the_goal(in_place: tuple[int, ...]) -> None:
    there = reports(QUEUE)
    draft = in_vain(settled(drafted(), there, *in_place), *(set(QUEUE) - {1, *in_place}))
    assert draft.next(there, others_may_come_back=False) == NoTurn.DONE
    assert draft.strand == (1, *in_place)


def test_one_that_has_led_in_vain_does_not_count_though_it_stands_nearer_to_the_goal() -> None:
    there = reports(QUEUE)
    draft = settled(drafted(cause=Cause.NO_WAY, led=(1,)), there)
    assert draft.strand == (2,)
    while (following := draft.next(there, others_may_come_back=False)) is not NoTurn.DONE:
        if isinstance(following, int):
            draft.end_turn(following, placed=following != 1)
    assert draft.strand[0] == 2


# --- rule 4: others are waited for ----------------------------------------------------------------------


def test_robots_that_may_come_back_are_waited_for_before_the_strand_goes_on_without_one_of_the_others() -> (
    None
):
    there = reports({robot: QUEUE[robot] for robot in (1, 2, 3)})
    draft = in_vain(settled(drafted(), there, 2), 3)
    assert draft.next(there, others_may_come_back=True) == NoTurn.WAIT
    assert draft.next(there, others_may_come_back=False) == NoTurn.DONE


# --- rule 5: letting in -----------------------------------------------------------------------------------


def test_a_strand_goes_on_as_it_was_if_a_robot_that_asks_to_be_let_in_finds_no_way() -> None:
    there = reports(QUEUE, BEFORE, 1, 2, 3)
    draft = settled(drafted(cause=Cause.PLEA), there, driven=(2, 3))
    assert draft.next(there, others_may_come_back=True) == 4
    draft.end_turn(4, placed=False)
    assert draft.next(there, others_may_come_back=True) == NoTurn.DONE
    assert draft.strand == (1, 2, 3)
