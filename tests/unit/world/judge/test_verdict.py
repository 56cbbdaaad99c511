import re
from collections.abc import Sequence
from typing import Any

import pytest
from msgspec.structs import replace as with_fields

from protocol.fence import May
from protocol.frames import Point
from protocol.keys import WORLD
from protocol.root import ROOT
from protocol.timeline import (
    Entry,
    FaultInjected,
    FenceChanged,
    GoalReached,
    PromiseBroken,
    Record,
    RobotArrived,
    RobotDied,
    RobotStranded,
    RouteLost,
    ScanServed,
    StepFinished,
    StrandJoined,
    ViewJoined,
    WorldResumed,
)
from tests.support.scenes.world_scenarios import scenario
from tests.support.strands import ordered, strand
from world.judge import table
from world.judge.books import Messages
from world.judge.ending import Ending
from world.judge.judgement import Breach, Judgement
from world.judge.monitor import Least
from world.judge.table import Rows, measure, rms_m
from world.judge.tally import Tally
from world.judge.verdict import Events, Facts, Verdict, pass_verdict
from world.scenario.scenario import Scenario, load

DOCS = ROOT / "docs" / "verdict.md"
JUDGED = Judgement(
    least_clearance=Least(distance_m=0.12, t_s=3.0, robot=1),
    least_separation=Least(distance_m=0.3, t_s=4.0, robot=1, other=2),
    least_moving_clearance=Least(),
    path_m=4.5,
    breaches=(),
)
ALL_WELL: list[tuple[str, float, Record]] = [
    ("r1", 9.0, GoalReached(x_m=1.0, y_m=0.0)),
    ("r1", 9.0, RobotArrived(progress_m=2.0)),
    ("r2", 9.5, RobotArrived(progress_m=1.5)),
]
BROKEN = PromiseBroken(invariant="S1", robot=2, measured_m=0.05, required_m=0.08, why="too near")


def tally_of(lines: list[tuple[str, float, Record]]) -> Tally:
    tally = Tally()
    begun = [(source, 0.0, record) for source, record in strand(10_001, 1, 2)]
    for n, (source, t_s, record) in enumerate([*begun, *lines], start=1):
        tally.hear(source, Entry(n=n, t_s=t_s, hlc="", record=record))
    return tally


def verdict(
    lines: list[tuple[str, float, Record]],
    *,
    ending: Ending = Ending.ARRIVED,
    judgement: Judgement = JUDGED,
    missing: int = 0,
    lost: int = 0,
    disagreements: tuple[str, ...] = (),
    living: frozenset[int] = frozenset({1, 2}),
    known: Scenario | None = None,
) -> Verdict:
    facts = Facts(
        scenario=known or scenario(),
        seed=1,
        speed=None,
        started_at="2026-11-20T00:00:00+00:00",
        ending=ending,
        absent="r2",
        living=living,
        tally=tally_of(lines),
        judgement=judgement,
        messages=Messages(
            sent=10,
            received=10,
            injected={},
            refused=0,
            unaccounted=0,
            left_out=(),
            disagreements=disagreements,
        ),
        events=Events(recorded=100, missing=missing, lost=lost),
        unstruck=(),
        sim_s=9.5,
        wall_s=1.0,
        cpu_s=0.5,
    )
    return pass_verdict(facts)


def test_a_run_that_kept_every_promise_is_ok() -> None:
    passed = verdict(ALL_WELL)
    assert (passed.ok, passed.exit_code, passed.reason) == (True, 0, "every living robot has arrived")
    assert [passed.clearance_m_min, passed.clearance_m_required] == pytest.approx([0.12, 0.08])
    assert [passed.separation_m_min, passed.separation_m_required] == pytest.approx([0.3, 0.08])
    assert (passed.violations, passed.table_rms_m) == (0, None)


BREACHED = with_fields(JUDGED, breaches=(Breach(t_s=4.0, broken=BROKEN),))
DIED = ("world", 5.0, RobotDied(robot=2, silent_since_s=4.2))
TOUCH = PromiseBroken(invariant="S1", robot=1, measured_m=0.0, required_m=0.0, why="touched an obstacle")
TOUCHED = with_fields(JUDGED, breaches=(Breach(t_s=2.2, broken=TOUCH),))
STRANDED = ("r3", 7.0, RobotStranded(epoch=10_003, robot=2, reason="its way is blocked", by=3))
STRANDED_TOO = ("r2", 7.0, RobotStranded(epoch=10_002, robot=1, reason="no place is free"))
LOST = ("r1", 6.0, RouteLost(reason="every gap is too narrow"))
WORLD_KILLED = (WORLD, 0.0, FaultInjected(fault="kill", rule="kill-1", process=WORLD))
WORLD_STARTED = (WORLD, 1.0, FaultInjected(fault="start", rule="kill-1", process=WORLD))
WORLD_IS_BACK = (WORLD, 1.0, WorldResumed(life=1, entries=10, torn_bytes=0))
WORLD_FROZEN = (WORLD, 3.0, FaultInjected(fault="freeze", rule="freeze-1", process=WORLD))
PROMISES = {
    "clearance": (
        verdict(ALL_WELL, judgement=BREACHED),
        "S1 (clearance) broken by robot 2 at t=4.0 s: too near (0.0500 m, required 0.0800 m)",
    ),
    "no contact": (
        verdict(ALL_WELL, judgement=TOUCHED),
        "S1 (clearance) broken by robot 1 at t=2.2 s: touched an obstacle",
    ),
    "nobody dies": (
        verdict([*ALL_WELL, DIED], ending=Ending.STUCK),
        "robot 2 died at t=4.2 s (known at t=5.0 s), and nobody had asked for it",
    ),
    "a way is found": (
        verdict([LOST], ending=Ending.ROUTE_LOST),
        "no_route: the leader lost its route at t=6.0 s: every gap is too narrow",
    ),
    "what was written stands in the timeline": (
        verdict(ALL_WELL, lost=2),
        "2 entries that were written do not stand in the timeline",
    ),
    "the books agree": (
        verdict(ALL_WELL, disagreements=("link/r1/r2 > r2: 4 messages arrived of 3 that were sent", "more")),
        "the books disagree: link/r1/r2 > r2: 4 messages arrived of 3 that were sent (and 1 more)",
    ),
    "something moves": (
        verdict(ALL_WELL[1:2], ending=Ending.STUCK),
        "by t=9.5 s nothing had moved for long: no step had been planned",
    ),
    "nobody is stranded": (
        verdict([*ALL_WELL[:2], STRANDED], ending=Ending.STRANDED),
        "no way for robot 2: its way is blocked (behind the body of robot 3)",
    ),
    "nobody is stranded for another reason": (
        verdict([STRANDED_TOO], ending=Ending.STRANDED),
        "no way for robot 1: no place is free",
    ),
    "somebody lives": (verdict([], ending=Ending.EXTINCT, living=frozenset()), "every robot has died"),
    "in time": (
        verdict(ALL_WELL[:2], ending=Ending.TIMED_OUT),
        "the time was up with 1 of 2 living robots arrived: "
        "the leader had reached the goal, and others were on the way to their places",
    ),
    "nobody is stranded when the time is up": (
        verdict([*ALL_WELL[:2], STRANDED], ending=Ending.TIMED_OUT),
        "the time was up with 1 of 2 living robots arrived: the leader had reached the goal, and others were "
        "on the way to their places; no way for robot 2: its way is blocked (behind the body of robot 3)",
    ),
    "all come": (verdict([], ending=Ending.MISSING), "robots never came: r2"),
    "the world does not stay killed": (
        verdict([WORLD_KILLED], ending=Ending.MISSING),
        "the world was killed by kill-1 and never started again",
    ),
    "the world does not stay frozen": (
        verdict([WORLD_FROZEN], ending=Ending.TIMED_OUT),
        "the world was frozen by freeze-1 and never thawed",
    ),
    "a world that is started again": (
        verdict([WORLD_KILLED, WORLD_STARTED], ending=Ending.MISSING),
        "robots never came: r2",
    ),
    "a world that has resumed the run": (
        verdict([WORLD_KILLED, WORLD_IS_BACK], ending=Ending.MISSING),
        "robots never came: r2",
    ),
    "the goal": (verdict(ALL_WELL[1:]), "the goal was not reached"),
    "all arrive": (verdict(ALL_WELL[:2]), "1 of 2 living robots arrived"),
    "a whole timeline": (verdict(ALL_WELL, missing=3), "3 entries of the timeline never came"),
}


@pytest.mark.parametrize(("passed", "reason"), PROMISES.values(), ids=PROMISES.keys())
def test_each_broken_promise_fails_the_run_and_is_named(passed: Verdict, reason: str) -> None:
    assert (passed.ok, passed.exit_code, passed.reason) == (False, 1, reason)


def test_only_a_lost_route_is_no_route() -> None:
    assert verdict([LOST], ending=Ending.ROUTE_LOST).no_route
    assert not verdict(ALL_WELL).no_route
    assert not verdict([LOST], ending=Ending.INTERRUPTED).no_route


def test_the_first_broken_promise_is_the_reason() -> None:
    late = with_fields(JUDGED, breaches=(Breach(t_s=4.3, broken=BROKEN),))
    assert verdict([*ALL_WELL, DIED], judgement=late).reason.startswith("robot 2 died")
    assert verdict([*ALL_WELL, DIED], judgement=BREACHED).reason.startswith("S1 (clearance) broken")


def test_a_world_that_was_killed_just_before_the_last_robot_arrived_fails_no_run() -> None:
    assert verdict([*ALL_WELL, WORLD_KILLED]).ok
    assert verdict([*ALL_WELL, WORLD_KILLED], ending=Ending.INTERRUPTED).exit_code == 130


def test_an_interrupted_run_has_the_exit_code_for_it() -> None:
    passed = verdict(ALL_WELL, ending=Ending.INTERRUPTED)
    assert (passed.ok, passed.exit_code, passed.reason) == (False, 130, "the run was interrupted")
    passed = verdict(ALL_WELL, ending=Ending.TERMINATED)
    assert (passed.ok, passed.exit_code, passed.reason) == (False, 143, "the run was told to end")
    passed = verdict(ALL_WELL, ending=Ending.HUNG_UP)
    assert (passed.ok, passed.exit_code, passed.reason) == (False, 129, "the terminal of the run was closed")


def test_a_run_that_ends_because_a_process_was_lost_has_failed() -> None:
    passed = verdict(ALL_WELL, ending=Ending.LOST_PROCESS)
    assert (passed.ok, passed.exit_code, passed.reason) == (False, 1, "another process of the run was lost")


def test_a_run_that_had_failed_before_it_was_interrupted_has_failed() -> None:
    passed = verdict([*ALL_WELL, DIED], ending=Ending.TERMINATED)
    assert (passed.exit_code, passed.reason[:12]) == (1, "robot 2 died")


KILLED = FaultInjected(fault="kill", rule="kill-1", process="r2")


def test_a_requested_death_breaks_no_promise() -> None:
    passed = verdict([*ALL_WELL[:2], ("world", 4.0, KILLED), ("world", 5.0, DIED[2])], living=frozenset({1}))
    assert (passed.ok, passed.reason, passed.robots_arrived) == (True, "every living robot has arrived", 1)


BOUND = ("r1", 9.6, ViewJoined(epoch=20_002))


def turn(robot: int) -> FenceChanged:
    return FenceChanged(epoch=20_002, turn=1, may=May.ONE, coordinator=2, life="2", named=robot)


@pytest.mark.parametrize(
    ("then", "arrived"),
    [
        ([BOUND], {1, 2}),
        ([BOUND, ("world", 9.7, turn(2))], {1, 2}),
        ([BOUND, ("world", 9.7, turn(1))], {2}),
        ([("world", 9.7, turn(1)), BOUND], {2}),
        ([("world", 9.4, turn(1)), BOUND], {1, 2}),
        ([BOUND, ("world", 9.9, turn(1))], {1, 2}),
        ([BOUND, ("world", 9.7, turn(1)), ("world", 9.9, turn(1))], {2}),
        ([BOUND, ("r1", 9.7, StrandJoined(epoch=20_002, rank=1))], {2}),
        ([BOUND, ("r1", 9.7, StrandJoined(epoch=20_002, rank=1)), BOUND], {2}),
    ],
    ids=["bound", "another", "turn", "heard before", "before", "too late", "twice", "strand", "bound again"],
)
def test_a_robot_that_is_bound_in_a_view_stands_where_it_has_arrived_until_it_has_a_turn(
    then: list[tuple[str, float, Record]], arrived: set[int]
) -> None:
    tally = tally_of([*ALL_WELL, *then])
    assert 1 not in tally.arrived, "it has no place in that view yet"
    tally.end(9.8)
    assert tally.arrived == arrived


def test_a_robot_that_was_bound_before_the_end_has_arrived_also_if_that_is_heard_after_the_end() -> None:
    """A judge that reads the log again hears it before the first robot that has settled."""
    tally = tally_of(ALL_WELL)
    tally.end(9.8)
    tally.hear("r1", Entry(n=100, t_s=9.6, hlc="", record=ViewJoined(epoch=20_002)))
    assert tally.arrived == {1, 2}
    tally.hear("r1", Entry(n=101, t_s=9.7, hlc="", record=StrandJoined(epoch=20_002, rank=1)))
    assert tally.arrived == {2}


@pytest.mark.parametrize(
    ("goal", "arrived"), [({"at_m": [4.0, 0.0], "tolerance_m": 0.1}, 2), (None, 1)], ids=["a goal", "none"]
)
def test_a_robot_that_arrived_in_an_older_strand_counts_only_where_there_is_a_goal_to_be_at(
    goal: dict[str, Any] | None, arrived: int
) -> None:
    """In swarm 264 without its goal, a robot that led itself alone had "arrived" 9 m from all others."""
    known = scenario() if goal is None else scenario(goal=goal)
    later = [(source, 9.6, record) for source, record in strand(20_001, 1)]
    lines = [*ALL_WELL, *later, ("r1", 9.7, RobotArrived(progress_m=2.0))]
    assert verdict(lines, known=known, ending=Ending.TIMED_OUT).robots_arrived == arrived


def test_every_scan_is_one_planning_event_with_any_number_of_revolutions() -> None:
    scan = ScanServed(revolutions=1, robot=1, x_m=0.0, y_m=0.0, heading_rad=0.0, hits=3)
    closer = ScanServed(revolutions=4, robot=1, x_m=0.0, y_m=0.0, heading_rad=0.0, hits=12)
    passed = verdict([("world", 0.1, scan), ("world", 0.2, closer), ("world", 0.3, scan)])
    assert (passed.planning_events, passed.scans) == (3, 6)


def test_the_table_is_measured_at_the_leaders_switching_positions() -> None:
    began = ordered(1, epoch=1, step=1, y_m=0.6)
    finished = StepFinished(robot=1, step=1, x_m=1.0, y_m=-1.0, clearance_m=None)
    positions = tally_of([("world", 0.0, began), ("world", 1.0, finished)]).switching_positions
    first, second = measure(scenario(), positions)
    assert first == pytest.approx((1.2, (2.0**2 + 1.1**2) ** 0.5))
    assert second == pytest.approx(((0.5**2 + 1.6**2) ** 0.5 - 0.3, 1.0))


def test_a_verdict_measures_only_as_many_positions_as_the_table_has_rows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A run may have thousands of steps, and its end must not take longer for them."""
    measured: list[int] = []

    def counted(known: Scenario, positions: Sequence[Point]) -> Rows:
        measured.append(len(positions))
        return measure(known, positions)

    monkeypatch.setattr(table, "measure", counted)
    places = [Point(x_m=0.0, y_m=0.0)] * 1000
    assert table.table_rms_m(scenario(), places) is None
    paper = load("paper")
    assert table.table_rms_m(paper, places) is not None
    assert measured == [0, len(paper.table_m or ())]


def test_the_rms_is_over_all_distances_and_none_without_a_whole_table() -> None:
    reference = ((1.0, 2.0), (3.0, 4.0))
    assert rms_m(((1.0, 2.0), (3.0, 4.2)), reference) == pytest.approx(0.1)
    assert rms_m(((1.0, 2.0),), reference) is None
    assert rms_m(reference, None) is None


def test_every_field_is_in_the_docs() -> None:
    said = re.findall(r"^\| (`[^|]*) \|", DOCS.read_text(), flags=re.MULTILINE)
    assert re.findall(r"`(\w+)`", " ".join(said)) == list(Verdict.__struct_fields__)


UNTRUE = PromiseBroken(invariant="A2", robot=2, measured_m=1.9, required_m=0.3, why="has not come up")
SHORT = PromiseBroken(invariant="A1", robot=1, measured_m=0.33, required_m=0.17, why="stands elsewhere")


@pytest.mark.parametrize(("untrue", "arrived", "reached"), [(UNTRUE, 1, True), (SHORT, 1, False)])
def test_an_arrival_that_poses_do_not_show_does_not_count(
    untrue: PromiseBroken, arrived: int, reached: bool
) -> None:
    judged = with_fields(JUDGED, breaches=(Breach(t_s=9.5, broken=untrue),))
    passed = verdict(ALL_WELL, judgement=judged)
    assert (passed.ok, passed.exit_code, passed.violations) == (False, 1, 1)
    assert (passed.robots_arrived, passed.goal_reached) == (arrived, reached)


def test_a_judge_that_failed_fails_the_run_and_says_why() -> None:
    passed = verdict(ALL_WELL, judgement=with_fields(JUDGED, failure="KeyError: 3 (motion.py:7 f)"))
    assert (passed.ok, passed.exit_code) == (False, 1)
    assert passed.reason == "the judge failed: KeyError: 3 (motion.py:7 f)"


def test_a_verdict_that_cannot_be_made_is_a_failed_one(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("of distances")

    monkeypatch.setattr("world.judge.verdict.table_rms_m", fail)
    passed = verdict(ALL_WELL)
    assert (passed.ok, passed.exit_code, passed.robots_arrived) == (False, 1, 2)
    assert passed.reason.startswith("the judge failed: ZeroDivisionError: of distances (test_verdict.py:")
