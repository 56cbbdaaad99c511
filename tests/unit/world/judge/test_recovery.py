from msgspec.structs import replace

from protocol.fence import Cause
from protocol.timeline import (
    FaultInjected,
    LeaderSucceeded,
    LinkBroken,
    Record,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    StrandHealed,
    ViewProposed,
)
from tests.support.strands import formed
from world.judge.recovery import Death, Heal, Recovery, Succession, is_relevant


def struck(fault: str, robot: int = 1) -> FaultInjected:
    return FaultInjected(fault=fault, rule="a", process=f"r{robot}")


def died(robot: int = 1, silent_since_s: float = 4.9) -> RobotDied:
    return RobotDied(robot=robot, silent_since_s=silent_since_s)


BROKEN = LinkBroken(neighbour=1, cause="token", silent_s=0.3)
PROPOSED = ViewProposed(epoch=7, cause=Cause.NEIGHBOUR_LOST, about=1, why="r1 is gone")
SUCCEEDED = LeaderSucceeded(epoch=8, before=1)
HEALED = StrandHealed(epoch=8, robots=2)
LEADER_KILLED: list[tuple[float, str, Record]] = [
    (7.9, "r2", formed(8, 2, 3)),
    (9.0, "r2", HEALED),  # sources come in any order
    (8.0, "r2", SUCCEEDED),
    (5.4, "r2", BROKEN),
    (5.5, "r2", PROPOSED),
    (5.0, "world", struck("kill")),
    (6.1, "world", died()),
]


def test_a_killed_leader_has_cause_detection_succession_and_heal() -> None:
    recovery = Recovery(LEADER_KILLED)
    assert recovery.deaths == (
        Death(
            robot=1, ordered=True, cause_s=5.0, detected_s=5.4, known_s=6.1, recovered_s=9.0, returned_s=None
        ),
    )
    assert recovery.successions == (
        Succession(robot=2, before=1, epoch=8, cause_s=5.0, detected_s=5.4, recovered_s=8.0),
    )
    assert recovery.heals == (Heal(epoch=8, members=(2, 3), cause_s=5.0, detected_s=5.4, recovered_s=9.0),)
    assert list(recovery.unrequested) == []


def test_a_crash_is_not_requested_and_dates_from_the_last_sign_of_life() -> None:
    recovery = Recovery([entry for entry in LEADER_KILLED if not isinstance(entry[2], FaultInjected)])
    (death,) = recovery.unrequested
    assert (death.ordered, death.cause_s) == (False, 4.9)


def test_a_robot_that_was_only_cut_off_and_returned_does_not_fail_a_run() -> None:
    lines: list[tuple[float, str, Record]] = [(6.1, "world", died()), (8.0, "world", RobotReturned(robot=1))]
    recovery = Recovery(lines)
    assert [death.returned_s for death in recovery.deaths] == [8.0]
    assert list(recovery.unrequested) == []


def test_a_restart_after_a_crash_does_not_excuse_the_crash() -> None:
    lines: list[tuple[float, str, Record]] = [(6.1, "world", died()), (8.0, "world", RobotRestarted(robot=1))]
    assert [death.returned_s for death in Recovery(lines).unrequested] == [None]


def test_without_a_broken_link_the_view_that_was_proposed_is_the_detection() -> None:
    recovery = Recovery([entry for entry in LEADER_KILLED if not isinstance(entry[2], LinkBroken)])
    assert [death.detected_s for death in recovery.deaths] == [5.5]
    assert [heal.detected_s for heal in recovery.heals] == [5.5]


def test_a_view_about_another_robot_or_for_another_reason_is_no_detection() -> None:
    others: list[tuple[float, str, Record]] = [
        (5.1, "r2", replace(PROPOSED, about=3)),
        (5.2, "r2", replace(PROPOSED, cause=Cause.DEAD_END)),
        (5.3, "r2", replace(PROPOSED, cause=Cause.START, about=None)),
    ]
    without = [entry for entry in LEADER_KILLED if not isinstance(entry[2], LinkBroken | ViewProposed)]
    assert [death.detected_s for death in Recovery([*without, *others]).deaths] == [None]
    unnamed = (5.6, "r2", replace(PROPOSED, cause=Cause.COORDINATOR_LOST, about=None))
    assert [death.detected_s for death in Recovery([*without, *others, unnamed]).deaths] == [5.6]


def test_a_heal_without_a_death_is_detected_when_a_view_that_changes_the_members_is_proposed() -> None:
    lines: list[tuple[float, str, Record]] = [
        (0.1, "r2", replace(PROPOSED, cause=Cause.START)),
        (7.0, "r2", replace(PROPOSED, cause=Cause.BLOCKED)),
        (8.0, "r2", replace(PROPOSED, cause=Cause.PLEA)),
        (9.0, "r2", HEALED),
        (10.0, "r2", PROPOSED),
    ]
    (heal,) = Recovery(lines).heals
    assert (heal.cause_s, heal.detected_s, heal.recovered_s) == (None, 8.0, 9.0)


def test_a_death_that_never_healed_has_no_time_of_recovery() -> None:
    (death,) = Recovery([(5.0, "world", struck("freeze")), (6.1, "world", died())]).deaths
    assert (death.ordered, death.detected_s, death.recovered_s) == (True, None, None)


def test_one_requested_fault_excuses_one_death() -> None:
    again = [*LEADER_KILLED, (20.0, "world", died(silent_since_s=18.9))]
    assert [death.ordered for death in Recovery(again).deaths] == [True, False]


def test_a_freeze_that_was_thawed_excuses_no_later_death() -> None:
    lines: list[tuple[float, str, Record]] = [
        (5.0, "world", struck("freeze")),
        (5.5, "world", struck("thaw")),
        (20.0, "world", died(silent_since_s=18.9)),
    ]
    assert [death.ordered for death in Recovery(lines).deaths] == [False]


def test_a_thaw_of_a_process_that_was_killed_while_it_was_frozen_takes_nothing_back() -> None:
    faults = [(5.0, struck("freeze")), (5.0, struck("kill")), (5.5, struck("thaw"))]
    (death,) = Recovery([*((t_s, "world", fault) for t_s, fault in faults), (7.0, "world", died())]).deaths
    assert (death.ordered, death.cause_s) == (True, 5.0)


def test_a_fault_of_another_robot_excuses_no_death() -> None:
    assert [
        d.ordered for d in Recovery([(5.0, "world", struck("kill", 2)), (6.0, "world", died())]).deaths
    ] == [False]


def test_a_heal_without_a_death_dates_from_when_the_broken_link_was_last_heard() -> None:
    silent = LinkBroken(neighbour=1, cause="silence", silent_s=3.0)
    (heal,) = Recovery([(8.0, "r2", silent), (8.1, "r2", PROPOSED), (12.0, "r2", HEALED)]).heals
    assert (heal.cause_s, heal.detected_s, heal.recovered_s) == (5.0, 8.0, 12.0)


def test_a_heal_that_includes_a_returned_robot_dates_from_its_return() -> None:
    back: list[tuple[float, str, Record]] = [
        (11.0, "world", RobotReturned(robot=1)),
        (11.2, "r2", replace(PROPOSED, cause=Cause.PLEA)),
        (13.0, "r2", StrandHealed(epoch=9, robots=3)),
    ]
    heal = Recovery([*LEADER_KILLED, *back]).heals[-1]
    assert (heal.cause_s, heal.detected_s, heal.recovered_s) == (11.0, 11.2, 13.0)


def test_each_heal_has_the_causes_since_the_one_before() -> None:
    second: list[tuple[float, str, Record]] = [
        (15.0, "world", struck("kill", 3)),
        (15.4, "r2", LinkBroken(neighbour=3, cause="token", silent_s=0.3)),
        (16.1, "world", died(3, 14.9)),
        (19.0, "r2", StrandHealed(epoch=10, robots=1)),
    ]
    heals = Recovery([*LEADER_KILLED, *second]).heals
    assert [(heal.cause_s, heal.detected_s, heal.recovered_s) for heal in heals] == [
        (5.0, 5.4, 9.0),
        (15.0, 15.4, 19.0),
    ]


def test_faults_of_messages_are_not_relevant_for_recovery() -> None:
    assert not is_relevant("r1", FaultInjected(fault="drop", rule="a", key="link/r1/r2", number=1))
    assert is_relevant("world", struck("kill"))
