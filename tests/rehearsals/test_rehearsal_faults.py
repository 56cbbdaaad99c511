"""Whole fleets under fault plans, in virtual time: each fault takes effect, and no invariant breaks.

Every failure prints the line that replays it.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from clew.rehearsal.recorded import verdict_on
from clew.rehearsal.rehearsal import Rehearsal
from protocol.errors import UsageError
from protocol.faults.plan import PLANS, Plan, load
from protocol.faults.rules import (
    Corrupt,
    Delay,
    Drop,
    Duplicate,
    Freeze,
    Kill,
    Partition,
    Restart,
    Rule,
    Slow,
    StepPoint,
)
from protocol.keys import robot_name
from protocol.root import ROOT
from protocol.timeline import (
    Entry,
    FaultInjected,
    MessageRefused,
    OrderAccepted,
    Record,
    RobotDied,
    RobotStarted,
    ScanServed,
    StepPlanned,
)
from tests.support.campaigns import clew, scene
from tests.support.deadline import DEADLINE_S
from tests.support.faults import injected
from tests.support.long import long
from world.judge.books import Messages
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.scenario.scenario import load as load_scenario

SHIPPED = sorted(path.stem for path in PLANS.glob("*.toml"))
OTHERS_TOO = ["killed-after-plan", "leader-frozen", "leader-killed", "loss-50", "middle-killed", "one-way"]
OTHERS_TOO += ["robot-restarted"]
"""Other tests read runs of the grove under these; `Runs` checks that they break no invariant."""


def rehearsed(tmp_path: Path, *rules: Rule, seed: int = 1) -> Rehearsal:
    """Five robots in a corridor, under these rules."""
    path = scene(tmp_path / "posts.json", goal=[4.0, 0.0], bounds=[0.0, -1.0, 6.0, 1.0])
    return Rehearsal(load_scenario(str(path)), seed, Plan(name="test", rules=rules)).run()


def entries_of(rehearsal: Rehearsal, source: str) -> list[Entry]:
    return [entry for by, entry in rehearsal.entries if by == source]


def process_faults(rehearsal: Rehearsal) -> list[tuple[float, str, str]]:
    """The process faults of a run: time, fault, process."""
    return [
        (entry.t_s, entry.record.fault, entry.record.process)
        for _, entry in rehearsal.entries
        if isinstance(entry.record, FaultInjected) and entry.record.process is not None
    ]


def message_counts(rehearsal: Rehearsal) -> Messages:
    return verdict_on(rehearsal, 1, started_at="", wall_s=0.0).messages


def driven_s(rehearsal: Rehearsal, robot: int) -> list[float]:
    """The times at which the robot's body accepted an order to drive."""
    return [
        entry.t_s
        for _, entry in rehearsal.entries
        if isinstance(entry.record, OrderAccepted)
        and (entry.record.robot, entry.record.target is None) == (robot, False)
    ]


def broken(rehearsal: Rehearsal) -> list[Record]:
    judgement = judge(rehearsal.world.scenario, rehearsal.entries)
    return [breach.broken for breach in judgement.breaches]


@pytest.mark.parametrize(
    "away",
    [
        Restart(target="world", from_s=2.0, after_s=1.5),
        Freeze(target="world", from_s=2.0, for_s=1.5),
    ],
)
def test_a_death_while_the_world_is_down_is_noticed_when_it_is_back(tmp_path: Path, away: Rule) -> None:
    world = rehearsed(tmp_path, away, Kill(target="r5", from_s=2.7)).world
    assert (world.survivors, world.ending) == (frozenset({1, 2, 3, 4}), Ending.ARRIVED)


def test_the_verdict_names_the_rules_that_never_took_effect(tmp_path: Path) -> None:
    rehearsal = rehearsed(
        tmp_path,
        Kill(target="r5", from_s=2.0),
        Kill(target="r4", robots=3, from_s=2.0),  # only the tail is behind it
        Drop(probability=0.1, until_s=5.0),
        Drop(from_s=500.0),
    )
    assert verdict_on(rehearsal, 1, started_at="", wall_s=0.0).unstruck == ("kill-2", "drop-4")


@pytest.mark.parametrize("name", [*sorted({*SHIPPED} - {*OTHERS_TOO}), *long(OTHERS_TOO)])
def test_no_shipped_plan_breaks_an_invariant(name: str) -> None:
    rehearsal = Rehearsal(load_scenario("grove"), 1, load(name)).run()
    again = f"replay with  ./launch/clew rehearse grove --seed 1 --faults {name}"
    assert broken(rehearsal) == [], again
    assert injected(rehearsal), again
    assert message_counts(rehearsal).unaccounted == 0, again


@pytest.mark.parametrize(
    ("rule", "taken"),
    [
        (Drop(probability=0.3), {"drop"}),
        (Delay(delay_s_max=0.5), set()),
        (Duplicate(probability=0.5, delay_s_max=0.3), set()),
        (Corrupt(probability=0.2), {"corrupt"}),
        (Partition(group=("r2",), others=("r3",), from_s=1.0, until_s=3.0), {"partition"}),
        (Freeze(target="r3", from_s=1.0, for_s=3.0), set()),
        (Restart(target="router", from_s=1.0, after_s=1.0), {"router"}),
        (Restart(target="world", from_s=1.0, after_s=0.5), {"world"}),
    ],
)
def test_every_message_is_accounted_for(tmp_path: Path, rule: Rule, taken: set[str]) -> None:
    balanced = message_counts(rehearsed(tmp_path, rule))
    assert balanced.injected.keys() == taken
    assert balanced.sent == balanced.received + sum(balanced.injected.values())
    assert balanced.unaccounted == 0


def test_each_message_fault_is_in_the_timeline_with_key_and_number(tmp_path: Path) -> None:
    rehearsal = rehearsed(tmp_path, Drop(probability=0.2, kinds=("ahead", "odometry")))
    struck = [
        (source, entry.record.key, entry.record.number)
        for source, entry in rehearsal.entries
        if isinstance(entry.record, FaultInjected)
    ]
    assert len(set(struck)) == len(struck) == sum(message_counts(rehearsal).injected.values()) > 50
    assert {str(key).split("/")[0] for _, key, _ in struck} == {"link", "body"}
    assert all(source in str(key) for source, key, _ in struck), "the receiver has recorded it"


def test_a_damaged_message_is_refused_by_the_codec_and_recorded(tmp_path: Path) -> None:
    rehearsal = rehearsed(tmp_path, Corrupt(probability=0.2, bits=1))
    refused = [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, MessageRefused)]
    assert len(refused) == injected(rehearsal)["corrupt"] > 50
    assert {each.reason for each in refused} == {"its checksum is not that of its content"}


def test_a_killed_process_sends_nothing_and_the_world_records_its_death(tmp_path: Path) -> None:
    rehearsal = rehearsed(tmp_path, Kill(target="r3", from_s=2.0))
    assert process_faults(rehearsal) == [(2.0, "kill", "r3")]
    assert max(entry.t_s for entry in entries_of(rehearsal, "r3")) <= 2.0
    died = [entry for _, entry in rehearsal.entries if isinstance(entry.record, RobotDied)]
    assert [entry.record.robot for entry in died if isinstance(entry.record, RobotDied)] == [3]
    assert died[0].t_s == pytest.approx(3.0, abs=0.15), "its token has gone, and no message came for 1 s"


def test_a_frozen_process_does_nothing_and_then_continues_with_the_newest_odometry(tmp_path: Path) -> None:
    rehearsal = rehearsed(tmp_path, Freeze(target="r1", from_s=2.0, for_s=4.0))
    assert process_faults(rehearsal) == [(2.0, "freeze", "r1"), (6.0, "thaw", "r1")]
    assert [at_s for at_s in driven_s(rehearsal, 1) if 2.0 < at_s < 6.0] == []
    own = [entry.t_s for entry in entries_of(rehearsal, "r1")]
    assert [at_s for at_s in own if 2.1 < at_s < 5.9] == [], (
        "it records nothing of the time when it was frozen"
    )
    assert max(own) > 6.0
    assert broken(rehearsal) == []


def test_a_restarted_process_counts_its_entries_from_1(tmp_path: Path) -> None:
    rehearsal = rehearsed(tmp_path, Restart(target="r4", from_s=2.0, after_s=1.0))
    assert process_faults(rehearsal) == [(2.0, "kill", "r4"), (3.0, "start", "r4")]
    own = entries_of(rehearsal, "r4")
    starts = [place for place, entry in enumerate(own) if isinstance(entry.record, RobotStarted)]
    assert [own[place].n for place in starts] == [1, 1]
    assert len(own) > starts[1] + 1


def test_a_slow_process_sends_fewer_orders(tmp_path: Path) -> None:
    def answers(*rules: Rule) -> int:
        rehearsal = rehearsed(tmp_path, *rules)
        drives = rehearsal.account.received["body/r1/drive"]
        return round(drives / rehearsal.world.over_s)

    assert answers() >= 9
    assert answers(Slow(target="r1", delay_s=0.5)) <= 3


def test_the_end_of_a_slow_fault_has_its_own_word(tmp_path: Path) -> None:
    rehearsal = rehearsed(tmp_path, Slow(target="r1", delay_s=0.5, from_s=0.5, for_s=1.0))
    assert [action for _, action, _ in process_faults(rehearsal)] == ["slow", "unslow"]
    drives = rehearsal.account.received["body/r1/drive"]
    assert round(drives / rehearsal.world.over_s) >= 8, "it is fast again"


@pytest.mark.parametrize("point", StepPoint)
def test_a_robot_dies_exactly_at_the_point_that_the_plan_names(tmp_path: Path, point: StepPoint) -> None:
    robot = 2 if point is StepPoint.BEFORE_ACK else 1
    rehearsal = rehearsed(tmp_path, Kill(target=robot_name(robot), point=point))
    ((at_s, _, struck),) = process_faults(rehearsal)
    said = [entry.record for entry in entries_of(rehearsal, struck)]
    plans = [record for record in said if isinstance(record, StepPlanned)]
    served_s = [
        entry.t_s
        for entry in entries_of(rehearsal, "world")
        if isinstance(entry.record, ScanServed) and entry.record.robot == robot
    ]
    assert at_s < 8.0
    assert broken(rehearsal) == []
    if point is StepPoint.AFTER_SCAN:
        assert plans == []
        assert at_s == pytest.approx(min(served_s), abs=0.03)
    if point is StepPoint.AFTER_PLAN:
        assert said[-1:] == plans
        assert driven_s(rehearsal, robot) == [], "no robot has learned of the step"
    if point is StepPoint.MID_DRIVE:
        assert len(plans) == 1
        assert min(driven_s(rehearsal, robot)) < at_s - 1.0
    if point is StepPoint.BEFORE_ACK:
        assert driven_s(rehearsal, robot) == []


@pytest.mark.parametrize("point", [StepPoint.AFTER_SCAN, StepPoint.AFTER_PLAN])
def test_a_robot_frozen_at_a_point_executes_its_remaining_commands_after_the_thaw(
    tmp_path: Path, point: StepPoint
) -> None:
    rehearsal = rehearsed(tmp_path, Freeze(target="r1", point=point, for_s=0.5))
    ((frozen_s, _, _), (thawed_s, _, _)) = process_faults(rehearsal)
    assert thawed_s == pytest.approx(frozen_s + 0.5, abs=0.03)
    assert min(driven_s(rehearsal, 1)) == pytest.approx(thawed_s, abs=0.03)
    plans = [entry.record for entry in entries_of(rehearsal, "r1") if isinstance(entry.record, StepPlanned)]
    assert [plan.step for plan in plans] == list(range(1, len(plans) + 1)), "no step is lost"
    assert broken(rehearsal) == []


def test_the_plan_can_be_changed_during_the_run(tmp_path: Path) -> None:
    path = scene(tmp_path / "posts.json")
    rehearsal = Rehearsal(load_scenario(str(path)), 1)
    for now_s in rehearsal.ticks():
        if now_s == pytest.approx(1.0):
            rehearsal.turn_to(Plan(name="deaf", rules=(Drop(probability=0.5),)))
    first_s = min(e.t_s for _, e in rehearsal.entries if isinstance(e.record, FaultInjected))
    assert first_s == pytest.approx(1.0, abs=0.2)


def test_no_fault_is_recorded_before_its_window_even_if_odometry_is_late(
    tmp_path: Path,
) -> None:
    rules = (
        Drop(kinds=("odometry",), receiver=("r2",), from_s=1.0, until_s=2.0),
        Delay(kinds=("odometry",), receiver=("r3",), delay_s_min=0.7, delay_s_max=0.8, from_s=0.95),
        Drop(probability=0.3, from_s=1.55),
    )
    rehearsal = rehearsed(tmp_path, *rules)
    from_s = {f"{rule.fault}-{place}": rule.from_s for place, rule in enumerate(rules, start=1)}
    struck = [(e.t_s, e.record) for _, e in rehearsal.entries if isinstance(e.record, FaultInjected)]
    assert {record.rule for _, record in struck} == from_s.keys()
    assert [(t_s, record) for t_s, record in struck if t_s < from_s[record.rule]] == []
    for robot in range(1, 6):
        told_s = [entry.t_s for entry in entries_of(rehearsal, robot_name(robot))]
        assert told_s == sorted(told_s)


def test_a_plan_that_cannot_be_rehearsed_is_refused_and_leaves_no_folder(tmp_path: Path) -> None:
    path = scene(tmp_path / "posts.json")
    with pytest.raises(UsageError, match="slow-1 slows the world, which only a live run can do"):
        rehearsed(tmp_path, Slow(target="world", delay_s=0.1))
    plan = tmp_path / "far.toml"
    plan.write_text('name = "far"\n[[rule]]\nfault = "kill"\ntarget = "r9"\n', encoding="utf-8")
    said = clew("rehearse", path, "--faults", plan, "--out", tmp_path / "run")
    assert (said.exit_code, said.stdout) == (2, "")
    assert said.stderr == f"Error: {plan}: $.rule[0].target: must be a robot of the fleet, r1 to r5, got r9\n"
    assert not (tmp_path / "run").exists()


def test_a_seed_determines_a_run_with_faults_to_the_byte_for_any_hash_order(tmp_path: Path) -> None:
    plan = tmp_path / "mixed.toml"
    plan.write_text(
        'name = "mixed"\n'
        '[[rule]]\nfault = "drop"\nprobability = 0.1\n'
        '[[rule]]\nfault = "delay"\nprobability = 0.2\ndelay_s_max = 0.3\n'
        '[[rule]]\nfault = "corrupt"\nprobability = 0.05\n'
        '[[rule]]\nfault = "partition"\ngroup = ["r4"]\nothers = ["router"]\nfrom_s = 2.0\nuntil_s = 4.0\n'
        '[[rule]]\nfault = "freeze"\ntarget = "tail"\nfrom_s = 2.0\nfor_s = 2.0\n'
        '[[rule]]\nfault = "restart"\ntarget = "leader"\nfrom_s = 3.0\nafter_s = 0.5\n',
        encoding="utf-8",
    )
    path = scene(tmp_path / "posts.json")
    runs = [
        subprocess.Popen(
            [
                sys.executable,
                "-m",
                "clew.cli",
                "rehearse",
                path,
                "-n",
                "4",
                "--faults",
                plan,
                "--out",
                tmp_path / name,
            ],
            env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONHASHSEED": name},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for name in ("1", "2")
    ]
    assert {run.wait(DEADLINE_S) for run in runs} <= {0, 1}
    first, second = ((tmp_path / name / "events.jsonl").read_bytes() for name in ("1", "2"))
    assert first == second
    assert first.count(b"fault.injected") > 100


@pytest.mark.parametrize("others_die", [False, True])
def test_a_robot_cut_off_from_the_others_raises_over_their_strand_only_when_its_leader_is_dead(
    tmp_path: Path, others_die: bool
) -> None:
    """It led alone, again and again, when the others had arrived, and then said that the route was lost."""
    others = ("r1", "r2", "r3", "r4")
    kills = [Kill(target=each, from_s=4.0) for each in others] if others_die else []
    path = scene(tmp_path / "posts.json", goal=[4.0, 0.0], bounds=[0.0, -1.0, 6.0, 1.0])
    plan = Plan(name="test", rules=(Partition(group=("r5",), others=others), *kills))
    rehearsal = Rehearsal(load_scenario(str(path)), 1, plan)
    for now_s in rehearsal.ticks():
        if now_s >= 90.0:
            break
    rehearsal.close()
    assert rehearsal.world.tally.arrived == ({5} if others_die else {1, 2, 3, 4})
