"""What the world has go wrong, by a plan and by hand; and how it is asked for."""

import asyncio
from pathlib import Path

import pytest

from protocol.errors import UsageError
from protocol.faults.manual_faults import WHERE_FILE, Wish, wish
from protocol.faults.plan import Plan
from protocol.faults.process_faults import Blow, Stroke
from protocol.faults.rules import Drop, Freeze, Kill, Restart, Rule, Slow, StepPoint, Thaw
from protocol.timeline import Entry, FaultInjected, Record, RobotStarted, StrandFormed, WorldResumed
from world.control import heard
from world.faults import GIVEN_MAX, TELL_S, Mischief

FORMED = StrandFormed(epoch=1, sensed=True, order=(2, 1, 3), path_length_m=1.0)


def entry(record: Record, t_s: float = 0.0) -> Entry:
    return Entry(n=1, t_s=t_s, hlc="", record=record)


def without_plan() -> Mischief:
    mischief = Mischief(Plan(name="none"), 1, robots=3)
    mischief.hear("r2", entry(FORMED))
    return mischief


def test_whoever_is_leader_by_now_is_struck_by_hand_at_once() -> None:
    mischief = without_plan()
    assert mischief.give(Kill(target="leader"), now_s=5.0, for_s=None) == "given-1"
    assert mischief.due(5.0) == [Stroke("given-1.r2", Blow.KILL, "r2")]
    assert mischief.due(6.0) == []


def test_a_robot_frozen_by_hand_for_a_while_is_thawed_then() -> None:
    mischief = without_plan()
    mischief.give(Freeze(target="r3", for_s=2.0), now_s=5.0, for_s=None)
    assert [stroke.blow for stroke in mischief.due(5.0)] == [Blow.FREEZE]
    assert mischief.due(6.9) == []
    assert [stroke.blow for stroke in mischief.due(7.0)] == [Blow.THAW]


def test_a_world_that_is_frozen_is_thawed_when_it_next_looks() -> None:
    mischief = without_plan()
    mischief.give(Freeze(target="world", for_s=9.0), now_s=5.0, for_s=None)
    assert [(stroke.blow, stroke.for_s) for stroke in mischief.due(5.0)] == [(Blow.FREEZE, 9.0)]
    assert [stroke.blow for stroke in mischief.due(5.02)] == [Blow.THAW]


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
    mischief = Mischief(Plan(name="none"), 1, robots=3)
    with pytest.raises(UsageError, match=why):
        mischief.give(rule, now_s=5.0, for_s=None)


def struck(process: str, *blows: Blow) -> Mischief:
    mischief = without_plan()
    for blow in blows:
        mischief.hear("world", entry(Stroke("given-1", blow, process).as_record()))
    return mischief


@pytest.mark.parametrize(
    ("blows", "rule", "why"),
    [
        ([Blow.KILL], Kill(target="r3"), "r3 is dead; restart has it start again"),
        ([Blow.FREEZE, Blow.KILL], Freeze(target="r3"), "r3 is dead"),
        ([], Thaw(target="r3"), "r3 is not frozen"),
        ([Blow.FREEZE, Blow.THAW], Thaw(target="r3"), "r3 is not frozen"),
        ([], Kill(target="r1", robots=3), "fewer than 3 stand from there on"),
    ],
)
def test_what_would_strike_nobody_is_refused(blows: list[Blow], rule: Rule, why: str) -> None:
    with pytest.raises(UsageError, match=why):
        struck("r3", *blows).give(rule, now_s=5.0, for_s=None)


@pytest.mark.parametrize(
    ("blows", "rule"),
    [
        ([Blow.KILL], Restart(target="r3")),
        ([Blow.KILL, Blow.START], Kill(target="r3")),
        ([Blow.FREEZE], Thaw(target="r3")),
        ([Blow.FREEZE], Kill(target="r3")),
    ],
)
def test_what_strikes_somebody_is_done(blows: list[Blow], rule: Rule) -> None:
    mischief = struck("r3", *blows)
    mischief.give(rule, now_s=5.0, for_s=None)
    assert [stroke.process for stroke in mischief.due(5.0)] == ["r3"]


def test_a_robot_that_was_killed_and_lives_again_can_be_struck() -> None:
    mischief = struck("r3", Blow.KILL)
    mischief.hear("r3", entry(RobotStarted(pid=1, incarnation="b")))
    mischief.give(Kill(target="r3"), now_s=5.0, for_s=None)
    assert [stroke.process for stroke in mischief.due(5.0)] == ["r3"]


def test_a_rule_for_messages_holds_from_now_for_as_long_as_was_said() -> None:
    mischief = without_plan()
    mischief.give(Drop(probability=0.5), now_s=5.0, for_s=2.0)
    (rule,) = mischief.of("r1").rules
    assert (rule.name, rule.from_s, rule.until_s) == ("given-1", 5.0, 7.0)


def test_rules_that_are_over_make_room_for_others() -> None:
    mischief = without_plan()
    for _ in range(GIVEN_MAX):
        mischief.give(Drop(), now_s=0.0, for_s=1.0)
    with pytest.raises(UsageError, match="no more than 100"):
        mischief.give(Drop(), now_s=0.5, for_s=1.0)
    mischief.give(Drop(), now_s=1.0, for_s=1.0)
    assert len(mischief.of("r1").rules) == 1


def test_robots_are_told_news_at_once_and_all_of_it_again_after_a_while() -> None:
    mischief = without_plan()
    assert mischief.news([1], 0.0) == {}  # nothing has ever gone wrong
    mischief.give(Drop(), now_s=0.0, for_s=None)
    first = mischief.news([1, 2], 0.0)
    assert first.keys() == {"r1", "r2"}
    assert mischief.news([1, 2], TELL_S / 2) == {}
    assert mischief.news([1, 2], TELL_S) == first


def test_which_rules_have_struck_is_told_so_that_they_do_not_again() -> None:
    mischief = Mischief(
        Plan(name="some", rules=(Kill(target="leader", point=StepPoint.MID_DRIVE),)), 1, robots=3
    )
    mischief.hear("r2", entry(FORMED))
    before = mischief.of("r2")
    mischief.hear("r2", entry(FaultInjected(fault="kill", rule="kill-1", process="r2")))
    after = mischief.of("r2")
    assert (before.struck, after.struck) == ((), ("kill-1",))
    assert after.number > before.number


def test_a_world_that_goes_on_gives_no_name_twice_and_is_believed_before_the_one_that_was_killed() -> None:
    killed, resumed = without_plan(), without_plan()
    killed.give(Drop(), now_s=1.0, for_s=None)
    killed.give(Kill(target="r3"), now_s=2.0, for_s=None)
    (stroke,) = killed.due(2.0)
    resumed.hear("r1", entry(FaultInjected(fault="drop", rule="given-1", key="link/r2/r1", number=4)))
    resumed.hear("world", entry(stroke.as_record()))
    resumed.hear("world", entry(WorldResumed(life=1, entries=9, torn_bytes=0)))
    assert resumed.give(Drop(), now_s=5.0, for_s=None) == "given-3"
    assert resumed.of("r1").number > killed.of("r1").number


def test_a_robot_is_told_how_slow_to_be_and_when_no_more() -> None:
    mischief = without_plan()
    mischief.give(Slow(target="r3", delay_s=0.2, for_s=1.0), now_s=0.0, for_s=None)
    mischief.due(0.0)
    assert (mischief.of("r3").slow_s, mischief.of("r1").slow_s) == (0.2, 0.0)
    mischief.due(1.0)
    assert mischief.of("r3").slow_s == 0.0


async def ask(run: Path, wished: Wish) -> str:
    return await asyncio.to_thread(wish, run, wished)


async def test_a_wish_is_answered_with_the_rules_name_or_with_why_there_is_none(tmp_path: Path) -> None:
    asked: list[tuple[Rule, float | None]] = []

    def give(rule: Rule, for_s: float | None) -> str:
        asked.append((rule, for_s))
        if isinstance(rule, Kill):
            raise UsageError("not him")
        return "given-7"

    async with heard(tmp_path, tmp_path, give):
        assert await ask(tmp_path, Wish(rule=Drop(probability=0.5), for_s=5.0)) == "given-7"
        with pytest.raises(UsageError, match="not him"):
            await ask(tmp_path, Wish(rule=Kill(target="r3")))
    assert asked == [(Drop(probability=0.5), 5.0), (Kill(target="r3"), None)]
    with pytest.raises(UsageError, match="no run goes on there"):
        await ask(tmp_path, Wish(rule=Drop()))


async def test_a_run_whose_world_was_killed_is_over(tmp_path: Path) -> None:
    (tmp_path / WHERE_FILE).write_text(str(tmp_path / "gone.sock"))
    with pytest.raises(UsageError, match="run"):
        await ask(tmp_path, Wish(rule=Drop()))


async def test_what_is_no_wish_is_refused_and_the_next_one_is_heard(tmp_path: Path) -> None:
    async with heard(tmp_path, tmp_path, lambda *_: "given-1"):
        reader, writer = await asyncio.open_unix_connection((tmp_path / WHERE_FILE).read_text())
        writer.write(b"garbage\n")
        assert b'"error":"' in await reader.readline()
        writer.close()
        assert await ask(tmp_path, Wish(rule=Drop())) == "given-1"
