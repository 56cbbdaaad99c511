"""What the world has go wrong, by a plan and by hand; and how it is asked for."""

import asyncio
from pathlib import Path

import pytest

from protocol.errors import UsageError
from protocol.faults.manual_faults import WHERE_FILE, FaultRequest, request_fault
from protocol.faults.plan import Plan
from protocol.faults.process_faults import ProcessAction, ProcessFault
from protocol.faults.rules import Drop, Freeze, Kill, Restart, Rule, Slow, StepPoint, Thaw
from protocol.timeline import Entry, FaultInjected, Record, RobotStarted, StrandFormed, WorldResumed
from world.control import heard
from world.faults import GIVEN_MAX, TELL_S, RunFaults

FORMED = StrandFormed(epoch=1, sensed=True, order=(2, 1, 3), path_length_m=1.0)


def entry(record: Record, t_s: float = 0.0) -> Entry:
    return Entry(n=1, t_s=t_s, hlc="", record=record)


def without_plan() -> RunFaults:
    faults = RunFaults(Plan(name="none"), 1, robots=3)
    faults.hear("r2", entry(FORMED))
    return faults


def test_whoever_is_leader_by_now_is_struck_by_hand_at_once() -> None:
    faults = without_plan()
    assert faults.add(Kill(target="leader"), now_s=5.0, for_s=None) == "given-1"
    assert faults.due(5.0) == [ProcessFault("given-1.r2", ProcessAction.KILL, "r2")]
    assert faults.due(6.0) == []


def test_a_robot_frozen_by_hand_for_a_while_is_thawed_then() -> None:
    faults = without_plan()
    faults.add(Freeze(target="r3", for_s=2.0), now_s=5.0, for_s=None)
    assert [fault.action for fault in faults.due(5.0)] == [ProcessAction.FREEZE]
    assert faults.due(6.9) == []
    assert [fault.action for fault in faults.due(7.0)] == [ProcessAction.THAW]


def test_a_world_that_is_frozen_is_thawed_when_it_next_looks() -> None:
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
def test_what_cannot_be_done_by_hand_is_refused(rule: Rule, why: str) -> None:
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
        ([ProcessAction.KILL], Kill(target="r3"), "r3 is dead; restart has it start again"),
        ([ProcessAction.FREEZE, ProcessAction.KILL], Freeze(target="r3"), "r3 is dead"),
        ([], Thaw(target="r3"), "r3 is not frozen"),
        ([ProcessAction.FREEZE, ProcessAction.THAW], Thaw(target="r3"), "r3 is not frozen"),
        ([], Kill(target="r1", robots=3), "fewer than 3 stand from there on"),
    ],
)
def test_what_would_strike_nobody_is_refused(actions: list[ProcessAction], rule: Rule, why: str) -> None:
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
def test_what_strikes_somebody_is_done(actions: list[ProcessAction], rule: Rule) -> None:
    faults = struck("r3", *actions)
    faults.add(rule, now_s=5.0, for_s=None)
    assert [fault.process for fault in faults.due(5.0)] == ["r3"]


def test_a_robot_that_was_killed_and_lives_again_can_be_struck() -> None:
    faults = struck("r3", ProcessAction.KILL)
    faults.hear("r3", entry(RobotStarted(pid=1, incarnation="b")))
    faults.add(Kill(target="r3"), now_s=5.0, for_s=None)
    assert [fault.process for fault in faults.due(5.0)] == ["r3"]


def test_a_rule_for_messages_holds_from_now_for_as_long_as_was_said() -> None:
    faults = without_plan()
    faults.add(Drop(probability=0.5), now_s=5.0, for_s=2.0)
    (rule,) = faults.of("r1").rules
    assert (rule.name, rule.from_s, rule.until_s) == ("given-1", 5.0, 7.0)


def test_rules_that_are_over_make_room_for_others() -> None:
    faults = without_plan()
    for _ in range(GIVEN_MAX):
        faults.add(Drop(), now_s=0.0, for_s=1.0)
    with pytest.raises(UsageError, match="no more than 100"):
        faults.add(Drop(), now_s=0.5, for_s=1.0)
    faults.add(Drop(), now_s=1.0, for_s=1.0)
    assert len(faults.of("r1").rules) == 1


def test_robots_are_told_news_at_once_and_all_of_it_again_after_a_while() -> None:
    faults = without_plan()
    assert faults.news([1], 0.0) == {}  # nothing has ever gone wrong
    faults.add(Drop(), now_s=0.0, for_s=None)
    first = faults.news([1, 2], 0.0)
    assert first.keys() == {"r1", "r2"}
    assert faults.news([1, 2], TELL_S / 2) == {}
    assert faults.news([1, 2], TELL_S) == first


def test_which_rules_have_struck_is_told_so_that_they_do_not_again() -> None:
    faults = RunFaults(
        Plan(name="some", rules=(Kill(target="leader", point=StepPoint.MID_DRIVE),)), 1, robots=3
    )
    faults.hear("r2", entry(FORMED))
    before = faults.of("r2")
    faults.hear("r2", entry(FaultInjected(fault="kill", rule="kill-1", process="r2")))
    after = faults.of("r2")
    assert (before.struck, after.struck) == ((), ("kill-1",))
    assert after.number > before.number


def test_a_world_that_goes_on_gives_no_name_twice_and_is_believed_before_the_one_that_was_killed() -> None:
    killed, resumed = without_plan(), without_plan()
    killed.add(Drop(), now_s=1.0, for_s=None)
    killed.add(Kill(target="r3"), now_s=2.0, for_s=None)
    (fault,) = killed.due(2.0)
    resumed.hear("r1", entry(FaultInjected(fault="drop", rule="given-1", key="link/r2/r1", number=4)))
    resumed.hear("world", entry(fault.as_record()))
    resumed.hear("world", entry(WorldResumed(life=1, entries=9, torn_bytes=0)))
    assert resumed.add(Drop(), now_s=5.0, for_s=None) == "given-3"
    assert resumed.of("r1").number > killed.of("r1").number


def test_a_robot_is_told_how_slow_to_be_and_when_no_more() -> None:
    faults = without_plan()
    faults.add(Slow(target="r3", delay_s=0.2, for_s=1.0), now_s=0.0, for_s=None)
    faults.due(0.0)
    assert (faults.of("r3").slow_s, faults.of("r1").slow_s) == (0.2, 0.0)
    faults.due(1.0)
    assert faults.of("r3").slow_s == 0.0


async def ask(run: Path, request: FaultRequest) -> str:
    return await asyncio.to_thread(request_fault, run, request)


async def test_a_wish_is_answered_with_the_rules_name_or_with_why_there_is_none(tmp_path: Path) -> None:
    asked: list[tuple[Rule, float | None]] = []

    def add(rule: Rule, for_s: float | None) -> str:
        asked.append((rule, for_s))
        if isinstance(rule, Kill):
            raise UsageError("not him")
        return "given-7"

    async with heard(tmp_path, tmp_path, add):
        assert await ask(tmp_path, FaultRequest(rule=Drop(probability=0.5), for_s=5.0)) == "given-7"
        with pytest.raises(UsageError, match="not him"):
            await ask(tmp_path, FaultRequest(rule=Kill(target="r3")))
    assert asked == [(Drop(probability=0.5), 5.0), (Kill(target="r3"), None)]
    with pytest.raises(UsageError, match="no run goes on there"):
        await ask(tmp_path, FaultRequest(rule=Drop()))


async def test_a_run_whose_world_was_killed_is_over(tmp_path: Path) -> None:
    (tmp_path / WHERE_FILE).write_text(str(tmp_path / "gone.sock"))
    with pytest.raises(UsageError, match="run"):
        await ask(tmp_path, FaultRequest(rule=Drop()))


async def test_what_is_no_wish_is_refused_and_the_next_one_is_heard(tmp_path: Path) -> None:
    async with heard(tmp_path, tmp_path, lambda *_: "given-1"):
        reader, writer = await asyncio.open_unix_connection((tmp_path / WHERE_FILE).read_text())
        writer.write(b"garbage\n")
        assert b'"error":"' in await reader.readline()
        writer.close()
        assert await ask(tmp_path, FaultRequest(rule=Drop())) == "given-1"
