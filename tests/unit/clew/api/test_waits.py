"""Which robots waited for which others: entries in, waits out."""

from clew.api.waits import Wait, waits_of
from protocol.fence import May
from protocol.timeline import (
    Entry,
    FaultInjected,
    FenceChanged,
    LinkBroken,
    LinkHeard,
    LinkSilent,
    Record,
    RobotHeld,
    RobotReleased,
    RobotStranded,
    StrandJoined,
    ViewJoined,
)
from tests.support.strands import formed

EPOCH = 20_002


def waits(*told: tuple[float, str, Record]) -> list[Wait]:
    return waits_of([(source, Entry(n=1, t_s=t_s, hlc="", record=record)) for t_s, source, record in told])


def fence(turn: int, may: May, named: int = 0) -> Record:
    return FenceChanged(epoch=EPOCH, turn=turn, may=may, coordinator=2, life="a", named=named)


def struck(fault: str, process: str) -> Record:
    return FaultInjected(fault=fault, rule="one", process=process)


def test_a_neighbour_is_waited_for_since_it_was_heard_last() -> None:
    assert waits(
        (3.0, "r2", LinkSilent(neighbour=1, silent_s=1.0)),
        (3.1, "r2", LinkSilent(neighbour=3, silent_s=1.0)),
        (4.0, "r2", LinkHeard(neighbour=1)),
        (5.0, "r2", LinkBroken(neighbour=3, cause="silence", silent_s=3.0)),
    ) == [Wait(2, 1, "silent", 2.0, 4.0), Wait(2, 3, "silent", 2.1, 5.0)]


def test_a_robot_that_holds_waits_for_the_one_behind_it() -> None:
    assert waits(
        (1.0, "r2", formed(EPOCH, 2, 4, 3)),
        (3.0, "r4", RobotHeld(behind_m=1.0)),
        (3.5, "r4", RobotReleased()),
        (4.0, "r2", RobotHeld(behind_m=1.0)),
    ) == [Wait(4, 3, "stretch", 3.0, 3.5), Wait(2, 4, "stretch", 4.0, None)]


def test_in_a_view_all_others_wait_for_the_robot_that_has_the_turn() -> None:
    joined = ViewJoined(epoch=EPOCH)
    assert waits(
        (1.0, "r1", joined),
        (1.0, "r2", joined),
        (1.0, "world", fence(1, May.ONE, named=2)),
        (1.5, "r3", joined),
        (4.0, "world", fence(2, May.ONE, named=3)),
        (6.0, "world", fence(3, May.ALL, named=1)),
    ) == [
        Wait(1, 2, "turn", 1.0, 4.0),
        Wait(3, 2, "turn", 1.5, 4.0),
        Wait(1, 3, "turn", 4.0, 6.0),
        Wait(2, 3, "turn", 4.0, 6.0),
    ]


def test_entries_of_robots_may_come_after_later_ones_of_the_world() -> None:
    assert waits(
        (2.0, "world", fence(1, May.ONE, named=2)),
        (1.0, "r1", ViewJoined(epoch=EPOCH)),
        (3.0, "r1", StrandJoined(epoch=EPOCH, rank=1)),
    ) == [Wait(1, 2, "turn", 2.0, 3.0)]


def test_a_robot_that_is_left_out_waits_until_it_has_a_place() -> None:
    assert waits(
        (2.0, "r1", RobotStranded(epoch=EPOCH, robot=3, reason="no way", by=2)),
        (9.0, "r3", StrandJoined(epoch=EPOCH, rank=2)),
    ) == [Wait(3, 2, "stranded", 2.0, 9.0)]


def test_nobody_waits_while_it_is_frozen_or_after_its_death() -> None:
    assert waits(
        (1.0, "r1", ViewJoined(epoch=EPOCH)),
        (1.0, "world", fence(1, May.ONE, named=2)),
        (2.0, "world", struck("kill", "r1")),
        (3.0, "world", fence(2, May.ONE, named=3)),
        (4.0, "world", struck("freeze", "r4")),
        (8.0, "world", struck("thaw", "r4")),
        (8.1, "r4", LinkSilent(neighbour=3, silent_s=5.0)),
        (8.2, "r4", LinkHeard(neighbour=3)),
    ) == [Wait(1, 2, "turn", 1.0, 2.0), Wait(4, 3, "silent", 8.0, 8.2)]
