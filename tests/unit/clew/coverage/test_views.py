"""Coverage counters of views, turn leases and formations."""

from collections import Counter

import pytest

from clew.coverage.situations import OF_CAUSE, Situation
from clew.coverage.views import Views
from protocol.fence import NUMBERS, Cause
from protocol.keys import WORLD
from protocol.timeline import (
    FaultInjected,
    Record,
    RobotBlocked,
    RobotPlaced,
    RobotStranded,
    StrandDissolved,
    StrandJoined,
    StrandReversed,
    ViewLeft,
    ViewProposed,
)
from tests.support.strands import Told, driving, formed, raised, strand, turn

E, F = 10_001, 20_002
"""The epochs of two views: of r1, then of r2."""
HERE = {"x_m": 0.0, "y_m": 0.0}


def counted(*told: Told, apart_s: float = 0.1) -> Counter[Situation]:
    """The situations in entries that are this far apart."""
    counts: Counter[Situation] = Counter()

    def count(situation: Situation) -> None:
        counts[situation] += 1

    views = Views(count)
    for place, (source, record) in enumerate(told):
        views.hear(source, place * apart_s, record)
    return counts


def struck(fault: str, process: str) -> Told:
    return WORLD, FaultInjected(fault=fault, rule="a", process=process)


def proposed(epoch: int) -> Told:
    return f"r{epoch % NUMBERS}", ViewProposed(epoch=epoch, cause=Cause.START, why="")


def by(robot: int, record: Record) -> Told:
    return f"r{robot}", record


@pytest.mark.parametrize("cause", Cause)
def test_a_view_is_counted_by_its_cause(cause: Cause) -> None:
    assert counted(raised(E, cause)) == Counter([OF_CAUSE[cause]] if cause in OF_CAUSE else [])


def test_of_two_raises_of_a_generation_one_replaces_the_other_or_is_not_taken() -> None:
    counts = counted(proposed(E), raised(E), proposed(10_003), raised(10_003), raised(F))
    assert (counts[Situation.RAISES_CROSSED], counts[Situation.EPOCH_REPLACED]) == (1, 1)
    assert counts[Situation.RAISE_IN_VAIN] == 0
    assert counted(proposed(E), proposed(10_003), raised(10_003), raised(F))[Situation.RAISE_IN_VAIN] == 1
    assert counted(proposed(E), proposed(E), raised(E))[Situation.RAISES_CROSSED] == 0


def test_a_view_that_is_raised_over_before_all_ends_early() -> None:
    assert counted(raised(E), raised(F))[Situation.VIEW_ENDED_EARLY] == 1
    assert counted(*strand(E, 1, 2), raised(F))[Situation.VIEW_ENDED_EARLY] == 0


def test_a_turn_is_taken_back_unless_its_robot_has_said_that_it_is_over() -> None:
    over = (
        by(3, RobotPlaced(**HERE, rank=1, turn=1)),
        by(3, RobotBlocked(**HERE, turn=1, reason="")),
    )
    for said in over:
        counts = counted(raised(E), turn(E, 1, 3), said, turn(E, 2))
        assert (counts[Situation.TURN_GIVEN], counts[Situation.TURN_TAKEN_BACK]) == (1, 0)
    assert counted(raised(E), turn(E, 1, 3), turn(E, 2, 4))[Situation.TURN_TAKEN_BACK] == 1
    counts = counted(raised(E), turn(E, 1, 3), raised(F))
    assert (counts[Situation.RAISED_IN_TURN], counts[Situation.TURN_TAKEN_BACK]) == (1, 0)


@pytest.mark.parametrize(
    ("before", "situation"),
    [
        ((raised(E),), Situation.COORDINATOR_KILLED_BOUND),
        ((raised(E), turn(E, 1, 3)), Situation.COORDINATOR_KILLED_JOINING),
        (strand(E, 2, 1), Situation.COORDINATOR_KILLED_DRIVING),
    ],
)
def test_a_killed_coordinator_counts_by_what_the_fence_says(
    before: tuple[Told, ...], situation: Situation
) -> None:
    assert counted(*before, struck("kill", "r1"))[situation] == 1
    assert counted(*before, struck("kill", "r3"))[situation] == 0


def test_a_robot_killed_or_restarted_in_a_turn_counts_by_whose_turn_it_is() -> None:
    given = (raised(E), turn(E, 1, 3))
    assert counted(*given, struck("kill", "r3"))[Situation.KILLED_IN_OWN_TURN] == 1
    assert counted(*given, struck("kill", "r2"))[Situation.KILLED_IN_TURN] == 1
    assert counted(*given, struck("kill", "r3"), struck("start", "r3"))[Situation.RESTARTED_IN_TURN] == 1
    assert counted(*given, turn(E, 2), struck("start", "r3"))[Situation.RESTARTED_IN_TURN] == 0


@pytest.mark.parametrize(
    ("fault", "process", "situation"),
    [
        ("freeze", "r1", Situation.COORDINATOR_FROZEN),
        ("start", "r1", Situation.COORDINATOR_RESTARTED),
        ("kill", "router", Situation.ROUTER_LOST_IN_VIEW),
        ("kill", "world", Situation.WORLD_LOST_IN_VIEW),
    ],
)
def test_a_fault_counts_only_while_a_view_forms(fault: str, process: str, situation: Situation) -> None:
    assert counted(raised(E), struck(fault, process))[situation] == 1
    assert counted(*strand(E, 1, 2), struck(fault, process))[situation] == 0
    assert counted(struck(fault, process))[situation] == 0


def test_a_cut_counts_only_while_a_view_forms() -> None:
    cut = by(2, FaultInjected(fault="partition", rule="a", key="view/r1/r2", number=1))
    assert counted(raised(E), cut)[Situation.CUT_WHILE_FORMING] == 1
    assert counted(*strand(E, 1, 2), cut)[Situation.CUT_WHILE_FORMING] == 0


def test_a_formation_is_late_or_lost_where_a_living_member_does_not_take_its_place() -> None:
    forms = (raised(E), by(1, formed(E, 1, 2)), driving(E, 1, 2), by(1, StrandJoined(epoch=E, rank=0)))
    second = by(2, StrandJoined(epoch=E, rank=1))
    assert counted(*forms, second, raised(F))[Situation.FORMATION_LOST] == 0
    assert counted(*forms, *[struck("slow", "r1")] * 5, second, raised(F))[Situation.FORMATION_LOST] == 1
    assert counted(*forms, raised(F), apart_s=0.4)[Situation.FORMATION_LOST] == 1
    assert counted(*forms, raised(F))[Situation.FORMATION_LOST] == 0, "there was no time to lose it"
    assert counted(*forms, struck("kill", "r2"), raised(F), apart_s=0.4)[Situation.FORMATION_LOST] == 0


def test_a_coordinator_or_a_new_leader_can_be_killed_in_a_succession() -> None:
    lost = (*strand(E, 1, 2, 3), raised(F, Cause.NEIGHBOUR_LOST))
    again, killed = (by(3, formed(F, 3, 2)), driving(F, 3, 2)), struck("kill", "r3")
    situation = Situation.KILLED_IN_SUCCESSION
    assert counted(*lost, struck("kill", "r2"))[situation] == 1, "it coordinates"
    assert counted(*lost, killed)[situation] == 0
    assert counted(*lost, *again, killed)[situation] == 1
    assert counted(*lost, *again, *[struck("slow", "r2")] * 21, killed)[situation] == 0, "it has succeeded"
    assert counted(*strand(E, 1, 2, 3), struck("kill", "r1"))[situation] == 0


def test_turning_round_dissolving_and_letting_in_count_when_the_next_strand_may_drive() -> None:
    turns = by(1, StrandReversed(epoch=E, cut_m=0.0, end_m=1.0, back_by_m=0.0))
    dissolves = by(1, StrandDissolved(epoch=E, blocked=2))
    for record, situation in ((turns, Situation.TURNED_ROUND), (dissolves, Situation.DISSOLVED)):
        assert counted(*strand(E, 1, 2), record, *strand(F, 2, 1))[situation] == 1
        assert counted(*strand(E, 1, 2), record, raised(F))[situation] == 0
    pleaded = raised(F, Cause.PLEA)
    more = (pleaded, by(2, formed(F, 1, 2, 3)), driving(F, 1, 2, 3))
    assert counted(*strand(E, 1, 2), *more)[Situation.LET_IN] == 1
    assert counted(*strand(E, 1, 2, 3), *more)[Situation.LET_IN] == 0


def test_robots_that_are_left_out_or_stranded_are_counted() -> None:
    counts = counted(raised(E), by(1, RobotStranded(epoch=E, robot=3, reason="x")), by(3, ViewLeft(epoch=E)))
    assert (counts[Situation.STRANDED], counts[Situation.LEFT_OUT]) == (1, 1)
