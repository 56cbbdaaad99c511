"""Process faults as conversations: times and timeline entries in, due faults out."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from protocol.faults.plan import Plan
from protocol.faults.process_faults import ProcessAction, ProcessFault, ProcessFaults
from protocol.faults.rules import Freeze, Kill, Partition, Restart, Rule, Slow, StepPoint, Thaw
from protocol.timeline import (
    Entry,
    FaultInjected,
    Record,
    RobotDied,
    RobotFailed,
    RobotReturned,
    RobotStarted,
    StrandJoined,
    ViewJoined,
    WorldResumed,
)
from tests.support.planned import planned
from tests.support.strands import formed as formation

FIVE = (1, 2, 3, 4, 5)


def faults(*rules: Rule, seed: int = 1) -> ProcessFaults:
    return ProcessFaults(Plan(name="test", rules=tuple(rules)), seed)


def tell(of: ProcessFaults, source: str, record: Record, t_s: float = 0.0) -> None:
    of.hear(source, Entry(n=1, t_s=t_s, hlc="", record=record))


def formed(order: Sequence[int] = FIVE, epoch: int = 10_002) -> Record:
    return formation(epoch, *order)


def said(due: Sequence[ProcessFault]) -> list[str]:
    return [f"{fault.action} {fault.process}" for fault in due]


def test_a_named_robot_is_struck_once_at_the_given_time() -> None:
    of = faults(Kill(target="r3", from_s=2.0))
    assert said(of.due(1.99)) == []
    assert of.due(2.0) == [ProcessFault("kill-1", ProcessAction.KILL, "r3")]
    assert of.due(2.0) == of.due(9.0) == []


def test_a_rule_for_a_role_waits_for_the_strand() -> None:
    of = faults(Kill(target="leader"), Kill(target="middle"), Kill(target="tail"))
    assert said(of.due(5.0)) == []
    tell(of, "r2", formed())
    assert said(of.due(5.1)) == ["kill r1", "kill r3", "kill r5"]


def test_a_second_rule_for_the_leader_waits_for_the_next_leader() -> None:
    of = faults(Kill(target="leader"), Kill(target="leader", name="again"))
    tell(of, "r1", formed())
    assert said(of.due(1.0)) == ["kill r1"]
    assert said(of.due(2.0)) == []
    tell(of, "r3", formed((2, 3, 4, 5), epoch=20_003))
    assert said(of.due(3.0)) == ["kill r2"]


def test_entries_of_an_older_epoch_do_not_change_roles() -> None:
    of = faults(Kill(target="leader", from_s=1.0))
    tell(of, "r4", formed((4, 5), epoch=70_004))
    tell(of, "r1", formed(epoch=10_001))
    tell(of, "r1", StrandJoined(epoch=10_001, rank=0, members=5))
    assert said(of.due(1.0)) == ["kill r4"]


@pytest.mark.parametrize(("target", "rank"), [("leader", 0), ("middle", 2), ("tail", 3)])
def test_a_robot_that_reads_only_its_own_entries_knows_its_own_role(target: str, rank: int) -> None:
    of = faults(Kill(target=target, point=StepPoint.AFTER_SCAN))
    tell(of, "r7", StrandJoined(epoch=10_002, rank=1, members=4))
    assert of.at_points("r7", [StepPoint.AFTER_SCAN], 1.0) == []
    tell(of, "r7", StrandJoined(epoch=20_002, rank=rank, members=4))
    assert said(of.at_points("r7", [StepPoint.AFTER_SCAN], 2.0)) == ["kill r7"]


def test_the_coordinator_is_the_robot_that_proposed_the_newest_view() -> None:
    of = faults(Kill(target="coordinator"), Kill(target="coordinator", name="again"))
    tell(of, "r1", ViewJoined(epoch=10_000))
    assert said(of.due(1.0)) == [], "a world that was started again has proposed it"
    tell(of, "r1", ViewJoined(epoch=20_003))
    tell(of, "r2", ViewJoined(epoch=10_002))
    assert said(of.due(1.0)) == ["kill r3"]
    assert said(of.due(2.0)) == []
    tell(of, "r2", ViewJoined(epoch=30_002))
    assert said(of.due(3.0)) == ["kill r2"]


def test_neighbours_are_counted_towards_the_tail_and_all_must_exist() -> None:
    of = faults(Kill(target="middle", robots=2), Kill(target="tail", robots=2, name="beyond"))
    tell(of, "r1", formed((5, 3, 1, 2)))
    assert said(of.due(0.0)) == ["kill r1", "kill r2"]


def test_from_step_counts_only_steps_of_the_leader() -> None:
    of = faults(Kill(target="tail", from_step=3))
    tell(of, "r1", formed())
    tell(of, "r2", planned(3))
    tell(of, "r1", planned(2))
    assert (said(of.due(1.0)), of.step) == ([], 2)
    tell(of, "r1", planned(3))
    assert said(of.due(1.1)) == ["kill r5"]


def test_a_rule_whose_window_closes_before_it_strikes_never_strikes() -> None:
    of = faults(Kill(target="leader", until_s=2.0))
    tell(of, "r1", formed())
    assert said(of.due(2.0)) == []


def test_a_process_frozen_for_a_time_is_thawed_after_it() -> None:
    of = faults(Freeze(target="r2", from_s=1.0, for_s=6.0))
    assert said(of.due(1.0)) == ["freeze r2"]
    assert said(of.due(6.9)) == []
    assert said(of.due(7.0)) == ["thaw r2"]


def test_a_process_frozen_without_a_time_is_thawed_only_by_a_rule() -> None:
    of = faults(Freeze(target="router", from_s=1.0), Thaw(target="router", from_s=3.0))
    assert [said(of.due(at_s)) for at_s in (1.0, 2.0, 3.0)] == [["freeze router"], [], ["thaw router"]]


def test_a_thaw_waits_until_its_target_is_frozen() -> None:
    of = faults(Thaw(target="r2"), Freeze(target="r2", from_s=3.0), Thaw(target="r2"))
    assert said(of.due(1.0)) == []
    assert said(of.due(3.0)) == ["freeze r2", "thaw r2"]
    assert said(of.due(4.0)) == []


def test_a_thaw_that_comes_with_the_end_of_a_freeze_has_nothing_to_thaw() -> None:
    of = faults(Freeze(target="r2", from_s=1.0, for_s=2.0), Thaw(target="r2", from_s=3.0))
    assert [said(of.due(at_s)) for at_s in (1.0, 3.0, 9.0)] == [["freeze r2"], ["thaw r2"], []]


def test_a_frozen_robot_of_which_a_late_message_comes_is_still_to_be_thawed() -> None:
    of = faults(Freeze(target="r2"), Thaw(target="r2", from_s=3.0))
    assert said(of.due(1.0)) == ["freeze r2"]
    tell(of, "world", RobotReturned(robot=2))
    assert said(of.due(3.0)) == ["thaw r2"]


def test_a_restarted_process_has_a_role_only_after_its_new_start() -> None:
    of = faults(Restart(target="tail", from_s=1.0, after_s=2.0), Kill(target="tail", from_s=1.5))
    tell(of, "r1", formed())
    assert said(of.due(1.0)) == ["kill r5"]
    assert said(of.due(2.9)) == []
    assert said(of.due(3.0)) == ["start r5", "kill r5"]


def test_a_slow_process_returns_to_its_normal_speed() -> None:
    of = faults(Slow(target="r2", delay_s=0.4, for_s=5.0))
    assert of.due(0.0) == [ProcessFault("slow-1", ProcessAction.SLOW, "r2", 0.4)]
    assert of.due(5.0) == [ProcessFault("slow-1", ProcessAction.UNSLOW, "r2")]


def test_a_rule_with_a_point_strikes_only_its_robot_at_the_nth_time() -> None:
    of = faults(Kill(target="leader", point=StepPoint.AFTER_PLAN, occurrence=2, from_s=1.0))
    tell(of, "r1", formed())
    assert of.has_points
    assert said(of.due(9.0)) == []
    assert of.at_points("r1", [StepPoint.AFTER_PLAN], 0.5) == [], (
        "its window is not open: this does not count"
    )
    assert of.at_points("r1", [StepPoint.AFTER_PLAN], 1.0) == []
    assert of.at_points("r1", [StepPoint.AFTER_SCAN], 1.1) == []
    assert of.at_points("r2", [StepPoint.AFTER_PLAN], 1.2) == []
    assert said(of.at_points("r1", [StepPoint.AFTER_SCAN, StepPoint.AFTER_PLAN], 1.3)) == ["kill r1"]
    assert of.at_points("r1", [StepPoint.AFTER_PLAN], 1.4) == []


def test_later_parts_of_a_fault_at_a_point_are_due_at_the_process_that_reads_the_timeline() -> None:
    rule = Restart(target="r2", point=StepPoint.BEFORE_ACK, after_s=2.0)
    its_own, launcher = faults(rule), faults(rule)
    (fault,) = its_own.at_points("r2", [StepPoint.BEFORE_ACK], 3.0)
    tell(launcher, "r2", fault.as_record(), t_s=3.0)
    assert said(launcher.due(4.9)) == []
    assert said(launcher.due(5.0)) == ["start r2"]


def test_reading_ones_own_entry_of_a_fault_does_not_repeat_it() -> None:
    of = faults(Freeze(target="r2", for_s=1.0))
    (fault,) = of.due(0.0)
    tell(of, "world", fault.as_record())
    assert said(of.due(1.0)) == ["thaw r2"]
    assert said(of.due(9.0)) == []


@given(st.lists(st.floats(0.0, 10.0), max_size=20))
def test_the_number_of_calls_does_not_change_the_faults(times_s: list[float]) -> None:
    rules: tuple[Rule, ...] = (
        Freeze(target="r1", from_s=1.0, for_s=2.0),
        Restart(target="r2", from_s=2.0, after_s=3.0),
        Slow(target="r3", from_s=4.0, delay_s=0.1, for_s=1.0),
    )
    of = faults(*rules)
    # A fault that is injected late has its full duration.
    seen = [each for at_s in [*sorted(times_s), 20.0, 30.0] for each in of.due(at_s)]
    assert sorted(said(seen)) == sorted(
        ["freeze r1", "thaw r1", "kill r2", "start r2", "slow r3", "unslow r3"]
    )
    assert said(seen).index("freeze r1") < said(seen).index("thaw r1")
    assert said(seen).index("kill r2") < said(seen).index("start r2")


@pytest.mark.parametrize("probability", [0.0, 0.3, 1.0])
def test_the_share_of_runs_in_which_a_rule_strikes_matches_its_probability(probability: float) -> None:
    hits = sum(bool(faults(Kill(target="r1", probability=probability), seed=n).due(0.0)) for n in range(1000))
    assert abs(hits - 1000 * probability) <= 4.5 * (1000 * probability * (1.0 - probability)) ** 0.5


def test_rules_that_have_struck_elsewhere_do_not_disable_other_rules() -> None:
    of = faults(Kill(target="leader"), Kill(target="r1", point=StepPoint.AFTER_SCAN, from_step=2))
    tell(of, "r1", formed())
    of.catch_up(["kill-1"], 2)
    assert of.due(1.0) == []
    assert said(of.at_points("r1", [StepPoint.AFTER_SCAN], 1.0)) == ["kill r1"]


def test_a_new_process_of_a_robot_counts_its_points_from_one() -> None:
    of = faults(Kill(target="leader", point=StepPoint.AFTER_SCAN, occurrence=2))
    tell(of, "r1", formed())
    assert of.at_points("r1", [StepPoint.AFTER_SCAN], 1.0) == []
    tell(of, "r2", StrandJoined(epoch=20_003, rank=0, members=4))
    assert of.at_points("r2", [StepPoint.AFTER_SCAN], 2.0) == []
    tell(of, "r2", RobotStarted(pid=7))
    assert of.at_points("r2", [StepPoint.AFTER_SCAN], 3.0) == []
    assert said(of.at_points("r2", [StepPoint.AFTER_SCAN], 4.0)) == ["kill r2"]


def test_a_fault_contains_its_duration() -> None:
    of = faults(Restart(target="router", after_s=1.5), Freeze(target="r2", for_s=2.0), Kill(target="r1"))
    assert [fault.for_s for fault in of.due(0.0)] == [1.5, 2.0, None]


def test_a_resumed_world_ends_its_restart_fault_early() -> None:
    of = faults(Restart(target="world", from_s=1.0, after_s=9.0), Restart(target="r1", after_s=9.0))
    assert said(of.due(1.0)) == ["kill world", "kill r1"]
    tell(of, "world", WorldResumed(life=1, entries=7, torn_bytes=0), t_s=2.0)
    assert said(of.due(2.0)) == ["start world"]
    assert said(of.due(11.0)) == ["start r1"]


def test_joining_steps_of_a_former_leader_do_not_count_as_steps_of_the_strand() -> None:
    of = faults(Kill(target="tail", from_step=3))
    tell(of, "r1", formed())
    tell(of, "r1", replace(planned(7), joins=True))
    assert (of.due(1.0), of.step) == ([], 0)


DEATHS: dict[str, list[tuple[str, Record]]] = {
    "killed by hand": [("world", FaultInjected(fault="kill", rule="given-1.r3", process="r3"))],
    "failed": [("r3", RobotFailed(reason="AssertionError"))],
    "missed": [("world", RobotDied(robot=3, silent_since_s=0.5))],
}


@pytest.mark.parametrize("death", DEATHS.values(), ids=DEATHS)
@pytest.mark.parametrize(
    "rule",
    [
        Kill(target="r3"),
        Freeze(target="r3"),
        Restart(target="middle", after_s=1.0),
        Slow(target="r3", delay_s=0.1),
    ],
)
def test_a_dead_robot_is_not_struck_until_it_is_alive_again(
    death: list[tuple[str, Record]], rule: Rule
) -> None:
    of = faults(rule)
    tell(of, "r1", formed())
    for source, record in death:
        tell(of, source, record, 1.0)
    assert said(of.due(2.0)) == []
    tell(of, "r3", RobotStarted(incarnation="2", pid=1))
    assert [fault.process for fault in of.due(3.0)] == ["r3"]


def test_a_frozen_or_cut_off_robot_can_be_struck() -> None:
    of = faults(Freeze(target="r3"), Kill(target="r3", from_s=3.0))
    assert said(of.due(0.0)) == ["freeze r3"]
    tell(of, "world", FaultInjected(fault="freeze", rule="freeze-1", process="r3"))
    tell(of, "world", RobotDied(robot=3, silent_since_s=0.5), 1.5)
    assert said(of.due(3.0)) == ["kill r3"]
    of = faults(Partition(group=("r3",), others=("router",)), Kill(target="r3"))
    tell(of, "world", RobotDied(robot=3, silent_since_s=0.5), 1.5)
    assert said(of.due(3.0)) == ["kill r3"]


def test_a_rule_strikes_a_robot_that_was_declared_dead_after_its_return() -> None:
    of = faults(Kill(target="r3"))
    tell(of, "world", RobotDied(robot=3, silent_since_s=0.5), 1.5)
    assert said(of.due(2.0)) == []
    tell(of, "world", RobotReturned(robot=3), 2.5)
    assert said(of.due(3.0)) == ["kill r3"]
