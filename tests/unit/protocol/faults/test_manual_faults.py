"""The faults that the world injects, by a plan and by hand."""

import pickle

import pytest

from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.faults.process_faults import ProcessAction, ProcessFault
from protocol.faults.rules import (
    GIVEN_MAX,
    Drop,
    Freeze,
    Kill,
    Partition,
    Restart,
    Rule,
    Slow,
    StepPoint,
    Thaw,
)
from protocol.timeline import (
    Entry,
    FaultInjected,
    Record,
    RobotDied,
    RobotFailed,
    RobotStarted,
    WorldResumed,
)
from protocol.wire.codec import decode, encode
from tests.support.strands import formed
from world.faults import TELL_S, RunFaults

FORMED = formed(10_002, 2, 1, 3)


def entry(record: Record, t_s: float = 0.0) -> Entry:
    return Entry(n=1, t_s=t_s, hlc="", record=record)


def without_plan() -> RunFaults:
    faults = RunFaults(Plan(name="none"), 1, robots=3)
    faults.hear("r2", entry(FORMED))
    return faults


def test_a_manual_rule_for_the_leader_strikes_the_present_leader_at_once() -> None:
    faults = without_plan()
    assert faults.add(Kill(target="leader"), now_s=5.0, for_s=None) == "given-1"
    assert faults.due(5.0) == [ProcessFault("given-1.r2", ProcessAction.KILL, "r2")]
    assert faults.due(6.0) == []


def test_a_robot_frozen_manually_for_a_time_is_thawed_after_it() -> None:
    faults = without_plan()
    faults.add(Freeze(target="r3", for_s=2.0), now_s=5.0, for_s=None)
    assert [fault.action for fault in faults.due(5.0)] == [ProcessAction.FREEZE]
    assert faults.due(6.9) == []
    assert [fault.action for fault in faults.due(7.0)] == [ProcessAction.THAW]


def test_a_frozen_world_is_thawed_at_its_next_look() -> None:
    faults = without_plan()
    faults.add(Freeze(target="world", for_s=9.0), now_s=5.0, for_s=None)
    assert [(fault.action, fault.for_s) for fault in faults.due(5.0)] == [(ProcessAction.FREEZE, 9.0)]
    assert [fault.action for fault in faults.due(5.02)] == [ProcessAction.THAW]


@pytest.mark.parametrize(
    ("rule", "why"),
    [
        (Kill(target="leader", point=StepPoint.AFTER_PLAN), "only a plan"),
        (Kill(target="tail", robots=2), "nobody is tail yet, or fewer than 2"),
        (Kill(target="r4"), r"fault kill: \$\.target: must be a robot of the fleet, r1 to r3, got r4"),
        (Drop(sender=("r4",)), r"fault drop: \$\.from\[0\]: must be .*, got r4"),
    ],
)
def test_an_impossible_manual_rule_is_refused(rule: Rule, why: str) -> None:
    faults = RunFaults(Plan(name="none"), 1, robots=3)
    with pytest.raises(UsageError, match=why):
        faults.add(rule, now_s=5.0, for_s=None)


def struck(process: str, *actions: ProcessAction) -> RunFaults:
    faults = without_plan()
    for action in actions:
        faults.hear("world", entry(ProcessFault("given-1", action, process).as_record()))
    return faults


@pytest.mark.parametrize(
    ("actions", "rule", "why"),
    [
        ([ProcessAction.KILL], Kill(target="r3"), "r3 is dead; a restart starts it again"),
        ([ProcessAction.FREEZE, ProcessAction.KILL], Freeze(target="r3"), "r3 is dead"),
        ([], Thaw(target="r3"), "r3 is not frozen"),
        ([ProcessAction.FREEZE, ProcessAction.THAW], Thaw(target="r3"), "r3 is not frozen"),
        ([], Kill(target="r1", robots=3), "fewer than 3 stand from there on"),
    ],
)
def test_a_manual_rule_without_a_possible_target_is_refused(
    actions: list[ProcessAction], rule: Rule, why: str
) -> None:
    with pytest.raises(UsageError, match=why):
        struck("r3", *actions).add(rule, now_s=5.0, for_s=None)


@pytest.mark.parametrize(
    ("actions", "rule"),
    [
        ([ProcessAction.KILL], Restart(target="r3")),
        ([ProcessAction.KILL, ProcessAction.START], Kill(target="r3")),
        ([ProcessAction.FREEZE], Thaw(target="r3")),
        ([ProcessAction.FREEZE], Kill(target="r3")),
    ],
)
def test_a_manual_rule_with_a_possible_target_is_injected(actions: list[ProcessAction], rule: Rule) -> None:
    faults = struck("r3", *actions)
    faults.add(rule, now_s=5.0, for_s=None)
    assert [fault.process for fault in faults.due(5.0)] == ["r3"]


def test_a_robot_that_was_killed_and_restarted_can_be_struck_again() -> None:
    faults = struck("r3", ProcessAction.KILL)
    faults.hear("r3", entry(RobotStarted(pid=1, incarnation="b")))
    faults.add(Kill(target="r3"), now_s=5.0, for_s=None)
    assert [fault.process for fault in faults.due(5.0)] == ["r3"]


def test_a_manual_message_rule_is_active_from_now_for_the_given_time() -> None:
    faults = without_plan()
    faults.add(Drop(probability=0.5), now_s=5.0, for_s=2.0)
    (rule,) = faults.of("r1").rules
    assert (rule.name, rule.from_s, rule.until_s) == ("given-1", 5.0, 7.0)


def test_rules_given_by_hand_get_no_name_that_a_rule_of_the_plan_has() -> None:
    plan = Plan(name="some", rules=(Drop(name="given-1"), Kill(name="given-7.r2", target="r2", from_s=9.0)))
    assert RunFaults(plan, 1, robots=3).add(Drop(), now_s=0.0, for_s=None) == "given-8"


def test_a_rule_that_is_refused_uses_up_no_name() -> None:
    faults = without_plan()
    refused: list[Rule] = [Drop(sender=("r9",)), Drop(sender=("r1",), kinds=("ask",))]
    refused += [Kill(target="r3", robots=2), Thaw(target="r1"), Kill(target="r1", point=StepPoint.MID_DRIVE)]
    for rule in refused:
        with pytest.raises(UsageError):
            faults.add(rule, now_s=0.0, for_s=None)
    names = [faults.add(Drop(), now_s=0.0, for_s=1.0) for _ in range(GIVEN_MAX)]
    with pytest.raises(UsageError, match="no more than 100"):
        faults.add(Drop(), now_s=0.5, for_s=1.0)
    assert [*names, faults.add(Drop(), now_s=1.0, for_s=None)] == [f"given-{n}" for n in range(1, 102)]


def test_rules_that_do_not_fit_into_one_message_are_refused_until_others_end() -> None:
    everybody = tuple(f"r{robot}" for robot in range(1, 1001))
    cut = Partition(group=everybody[:500], others=everybody[500:])
    struck = Plan(name="long", rules=tuple(Kill(name=f"{n:064}", target="r1") for n in range(400)))
    faults = RunFaults(struck, 1, robots=1000)

    def give_all() -> None:
        for _ in range(GIVEN_MAX):
            faults.add(cut, now_s=0.0, for_s=None)

    with pytest.raises(UsageError, match="do not fit into one message"):
        give_all()
    for name in struck.names:
        faults.hear("world", entry(FaultInjected(fault="kill", rule=name, process="r1")))
    assert decode(encode(faults.of("r1"), 1))[1] == faults.of("r1")
    faults.end("given-1", now_s=1.0)
    faults.add(cut, now_s=1.0, for_s=None)


def test_expired_rules_make_room_for_new_ones() -> None:
    faults = without_plan()
    for _ in range(GIVEN_MAX):
        faults.add(Drop(), now_s=0.0, for_s=1.0)
    with pytest.raises(UsageError, match="no more than 100"):
        faults.add(Drop(), now_s=0.5, for_s=1.0)
    faults.add(Drop(), now_s=1.0, for_s=1.0)
    assert len(faults.of("r1").rules) == 1


def test_robots_get_new_faults_at_once_and_the_whole_state_again_later() -> None:
    faults = without_plan()
    assert faults.news([1], 0.0) == {}  # there has been no fault
    faults.add(Drop(), now_s=0.0, for_s=None)
    first = faults.news([1, 2], 0.0)
    assert first.keys() == {"r1", "r2"}
    assert faults.news([1, 2], TELL_S / 2) == {}
    assert faults.news([1, 2], TELL_S) == first


def test_rules_that_have_struck_are_sent_to_robots_so_that_they_strike_only_once() -> None:
    faults = RunFaults(
        Plan(name="some", rules=(Kill(target="leader", point=StepPoint.MID_DRIVE),)), 1, robots=3
    )
    faults.hear("r2", entry(FORMED))
    before = faults.of("r2")
    faults.hear("r2", entry(FaultInjected(fault="kill", rule="kill-1", process="r2")))
    after = faults.of("r2")
    assert (before.struck, after.struck) == ((), ("kill-1",))
    assert after.number > before.number


def test_thousands_of_robots_that_are_restarted_by_hand_leave_nothing_behind() -> None:
    faults, size_bytes = without_plan(), dict[int, int]()
    for number in range(1, 1501):
        faults.add(Restart(target="r3", after_s=0.5), now_s=float(number), for_s=None)
        for injected in (*faults.due(float(number)), *faults.due(number + 0.5)):
            faults.hear("world", entry(injected.as_record(), float(number)))
        faults.hear("r3", entry(RobotStarted(pid=1, incarnation=f"{number}")))
        size_bytes[number] = len(pickle.dumps(faults))
    assert size_bytes[1500] <= size_bytes[1000]
    assert decode(encode(faults.of("r1"), 1))[1] == faults.of("r1")


def test_a_resumed_world_reuses_no_rule_name_and_overrides_the_killed_world() -> None:
    killed, resumed = without_plan(), without_plan()
    killed.add(Drop(), now_s=1.0, for_s=None)
    killed.add(Kill(target="r3"), now_s=2.0, for_s=None)
    (fault,) = killed.due(2.0)
    resumed.hear("r1", entry(FaultInjected(fault="drop", rule="given-1", key="link/r2/r1", number=4)))
    resumed.hear("world", entry(fault.as_record()))
    resumed.hear("world", entry(WorldResumed(life=1, entries=9, torn_bytes=0)))
    assert resumed.add(Drop(), now_s=5.0, for_s=None) == "given-3"
    assert resumed.of("r1").number > killed.of("r1").number


@pytest.mark.parametrize("digits", ["9" * 1900, "9" * 70, "\u0663"])
def test_a_robot_cannot_make_the_names_of_manual_rules_too_long_for_a_message(digits: str) -> None:
    faults = without_plan()
    faults.hear("r2", entry(FaultInjected(rule=f"given-{digits}", fault="drop")))
    faults.add(Drop(), now_s=5.0, for_s=None)
    told = faults.of("r1")
    assert decode(encode(told, 1)) == (1, told)
    assert [rule.name for rule in told.rules] == ["given-1"]


def test_a_robot_gets_its_delay_and_the_end_of_it() -> None:
    faults = without_plan()
    faults.add(Slow(target="r3", delay_s=0.2, for_s=1.0), now_s=0.0, for_s=None)
    faults.due(0.0)
    assert (faults.of("r3").slow_s, faults.of("r1").slow_s) == (0.2, 0.0)
    faults.due(1.0)
    assert faults.of("r3").slow_s == 0.0


def test_a_manual_rule_for_messages_is_ended_by_its_name_and_only_once() -> None:
    faults = without_plan()
    cut, lost = (faults.add(rule, now_s=5.0, for_s=None) for rule in (Partition(group=("r1",)), Drop()))
    before = faults.of("r1").number
    faults.end(cut, now_s=6.0)
    assert [rule.name for rule in faults.of("r1").rules] == [lost]
    assert faults.of("r1").number > before
    with pytest.raises(UsageError, match="no rule given-1 for messages is active"):
        faults.end(cut, now_s=6.0)


@pytest.mark.parametrize(
    "rule", [Partition(group=("r1",), period_s=10.0, cut_s=1.0), Drop(from_step=4)], ids=["pauses", "waits"]
)
def test_a_manual_rule_that_does_not_strike_at_the_moment_can_be_ended(rule: Rule) -> None:
    faults = without_plan()
    name = faults.add(rule, now_s=1.0, for_s=None)
    faults.end(name, now_s=3.0)
    assert faults.of("r1").rules == ()


def test_a_manual_rule_whose_time_is_over_cannot_be_ended() -> None:
    faults = without_plan()
    name = faults.add(Drop(), now_s=1.0, for_s=1.0)
    with pytest.raises(UsageError, match="no rule given-1 for messages is active"):
        faults.end(name, now_s=2.0)


def test_a_manual_rule_says_what_it_is_in_a_plan() -> None:
    faults = without_plan()
    name, (kill, after) = faults.resolve(Kill(target="leader", robots=2), now_s=5.0, for_s=None)
    assert name == "given-1"
    assert kill == Kill(name="given-1.r2", target="r2", from_s=5.0)
    assert after == Kill(name="given-1.r1", target="r1", from_s=5.0)
    assert faults.due(5.0) == []


@pytest.mark.parametrize(
    ("source", "record"),
    [("r3", RobotFailed(reason="AssertionError")), ("world", RobotDied(robot=3, silent_since_s=0.0))],
)
def test_a_manual_rule_cannot_strike_a_dead_robot_but_can_restart_it(source: str, record: Record) -> None:
    run_faults = without_plan()
    run_faults.hear(source, entry(record))
    for rule in (Kill(target="r3"), Freeze(target="tail"), Slow(target="r3", delay_s=0.1)):
        with pytest.raises(UsageError, match="r3 is dead; a restart starts it again"):
            run_faults.add(rule, now_s=1.0, for_s=None)
    run_faults.add(Restart(target="r3"), now_s=1.0, for_s=None)
    assert [fault.action for t_s in (1.0, 1.1) for fault in run_faults.due(t_s)] == [
        ProcessAction.KILL,
        ProcessAction.START,
    ]


def test_a_manual_rule_can_strike_a_robot_that_may_be_cut_off() -> None:
    run_faults = without_plan()
    run_faults.add(Partition(group=("r3",), others=("router",)), now_s=0.0, for_s=None)
    run_faults.hear("world", entry(RobotDied(robot=3, silent_since_s=0.0)))
    assert run_faults.add(Kill(target="r3"), now_s=1.0, for_s=None) == "given-2"


def test_a_robot_is_killed_once_if_a_plan_and_a_manual_rule_are_due_together() -> None:
    run_faults = RunFaults(Plan(name="plan", rules=(Kill(target="r3", from_s=1.0),)), 1, robots=3)
    run_faults.add(Kill(target="r3"), now_s=1.0, for_s=None)
    assert [fault.process for fault in run_faults.due(1.0)] == ["r3"]
    assert run_faults.due(2.0) == []


def test_a_process_fault_holds_a_robot_up_until_it_is_undone() -> None:
    faults = without_plan()
    seen = []
    for action in ("freeze", "thaw", "kill"):
        faults.hear("world", entry(FaultInjected(fault=action, rule="given-1", process="r2")))
        seen.append(faults.hold_up("r2"))
    faults.hear("r2", entry(RobotStarted(pid=1, incarnation="b")))
    assert [*seen, faults.hold_up("r2"), faults.hold_up("r1")] == [True, False, True, False, False]
