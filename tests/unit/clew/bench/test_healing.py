"""Detection and succession come from the wall clocks of a timeline; bounds are for the slowest run."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from clew.bench.healing import Healing, HealingRuns, LeaderFault, figures, healing_in
from clew.bench.result import all_met
from clew.fleet.live import Ended
from clew.rehearsal.logbook import NTP64_PER_S
from protocol.faults.fit import check_fits
from protocol.frames import Point
from protocol.timeline import Entry, FaultInjected, LeaderSucceeded, LinkBroken, Record, StrandHealed
from tests.support.campaigns import clew
from tests.support.deadline import DEADLINE_S
from tests.support.strands import formed, ordered
from world.record.lines import Line

KILLED = FaultInjected(fault="kill", rule="kill-1", process="r1")
BROKEN = LinkBroken(neighbour=1, cause="token", silent_s=0.4)
SUCCEEDED = LeaderSucceeded(epoch=2, before=1)
HEALED = StrandHealed(epoch=2, robots=2)
ORDERED = ordered(2, epoch=2, step=2, target=Point(x_m=1.0, y_m=0.0))


def at(wall_s: float, source: str, record: Record) -> Line:
    """An entry made at that time by the wall clock; simulated time stands still."""
    hlc = f"{round(wall_s * NTP64_PER_S)}/00"
    return source, Entry(n=1, t_s=3.0, hlc=hlc, record=record)


def test_times_are_of_the_wall_clock_and_do_not_depend_on_the_order_of_recording() -> None:
    lines = [
        at(8.0, "r2", HEALED),
        at(6.2, "world", ordered(2, epoch=2, step=2, target=Point(x_m=1.0, y_m=0.0), number=2)),
        at(6.1, "world", ORDERED),
        at(6.05, "world", ordered(3, epoch=2, target=Point(x_m=1.0, y_m=0.0))),
        at(6.05, "world", ordered(2, epoch=2)),
        at(5.95, "world", ordered(2, epoch=1, target=Point(x_m=1.0, y_m=0.0))),
        at(5.9, "r2", SUCCEEDED),
        at(5.7, "r3", formed(2, 2, 3)),
        at(5.5, "r2", BROKEN),
        at(5.0, "world", KILLED),
        at(4.5, "r1", formed(1, 1, 2, 3)),
        at(4.0, "world", FaultInjected(fault="drop", rule="drop-1", key="link/r1/r2", number=3)),
    ]
    healing = healing_in(lines)
    assert healing is not None
    assert healing.cause_s == 3.0
    assert (healing.detection_s, healing.succession_s) == pytest.approx((0.5, 0.4))
    assert (healing.ordered_s, healing.healed_s) == pytest.approx((1.1, 3.0))


def test_where_the_strand_turns_round_first_the_robot_at_its_other_end_gives_the_first_order() -> None:
    lines = [
        at(5.0, "world", KILLED),
        at(5.5, "r2", BROKEN),
        at(5.7, "r3", formed(2, 2, 3)),
        at(5.9, "r2", SUCCEEDED),
        at(6.3, "r3", formed(3, 3, 2)),
        at(6.4, "world", ordered(2, epoch=3, step=2, target=Point(x_m=1.0, y_m=0.0))),
        at(6.5, "world", ordered(3, epoch=3, step=2, target=Point(x_m=1.0, y_m=0.0))),
        at(6.6, "r3", HEALED),
    ]
    healing = healing_in(lines)
    assert healing is not None
    assert healing.ordered_s == pytest.approx(1.5)


def test_entries_of_another_robot_or_from_before_the_fault_do_not_count() -> None:
    lines = [
        at(4.0, "r2", BROKEN),
        at(5.0, "world", KILLED),
        at(5.1, "r3", LinkBroken(neighbour=2, cause="token", silent_s=0.4)),
        at(5.2, "r4", LeaderSucceeded(epoch=2, before=3)),
        at(5.3, "r4", HEALED),
    ]
    assert healing_in(lines) == Healing(cause_s=3.0)
    assert healing_in(lines[:1]) is None


SOON = Healing(cause_s=3.0, detection_s=0.4, succession_s=0.2, ordered_s=0.7, healed_s=2.0)


def are_met(fault: LeaderFault, *each: Healing | None) -> bool:
    return all_met(figures(HealingRuns(fault=fault, loads=(1.0,), each=each)))


@given(st.lists(st.floats(0.01, 3.0), min_size=1, max_size=40))
def test_runs_are_within_a_bound_exactly_when_the_slowest_is(detections_s: list[float]) -> None:
    measured = [replace(SOON, detection_s=each) for each in detections_s]
    is_quick = max(detections_s) <= LeaderFault.KILL.detection_s_max
    assert are_met(LeaderFault.KILL, *measured) is is_quick


def test_one_run_in_which_an_event_never_came_fails_even_if_the_others_were_quick() -> None:
    quick = [SOON] * 4
    assert are_met(LeaderFault.KILL, *quick)
    for slow in (None, Healing(cause_s=3.0), Healing(cause_s=3.0, detection_s=0.4, succession_s=0.2)):
        assert not are_met(LeaderFault.KILL, *quick, slow)


def test_the_median_of_the_first_orders_has_a_bound_where_the_leader_is_killed() -> None:
    late = replace(SOON, ordered_s=1.2)
    assert are_met(LeaderFault.KILL, SOON, SOON, late)
    assert not are_met(LeaderFault.KILL, SOON, late, late)
    assert are_met(LeaderFault.FREEZE, SOON, late, late)


def test_the_figures_say_never_where_an_event_or_the_fault_never_came() -> None:
    found = figures(HealingRuns(fault=LeaderFault.KILL, loads=(1.0,), each=(SOON, None, SOON)))
    assert [each.measured.median for each in found] == [0.4, 0.2, 0.7, 2.0]
    assert [each.measured.most for each in found] == [None] * 4
    assert [each.met for each in found] == [False, False, True, False]


@pytest.mark.parametrize("fault", LeaderFault)
def test_each_run_has_the_fault_at_another_moment(fault: LeaderFault) -> None:
    plans = [fault.plan(run) for run in range(20)]
    for plan in plans:
        check_fits(plan, robots=5)
        assert [(rule.fault, rule.target) for rule in plan.rules] == [(fault, "leader")]  # type: ignore[union-attr]  # of processes
    assert len({plan.rules[0].from_s for plan in plans}) == 20


def test_a_bad_scenario_is_refused_in_one_line_before_any_fleet_starts(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def no_fleet(*_: object, **__: object) -> Ended:
        raise AssertionError("a fleet was started")

    monkeypatch.setattr("clew.verbs.bench_healing.run_fleet", no_fleet)
    told = clew("bench", "healing", "nope")
    assert (told.exit_code, told.stdout, told.stderr.count("\n")) == (2, "", 1)
    assert "nope" in told.stderr


@pytest.mark.long
@pytest.mark.processes
def test_the_verb_measures_leaders_of_live_fleets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clew.verbs.bench_healing.WALL_S_MAX", DEADLINE_S)  # a run ends when it has healed
    told = clew("bench", "healing", "--runs", "1", "--json")
    result = json.loads(told.stdout)
    rows = result["details"]
    assert len(result["figures"]) == 4 * len(rows)
    assert [row["fault"] for row in rows] == ["kill", "freeze"]
    for row in rows:
        (run,) = row["each"]
        assert 0.0 < run["detection_s"] < run["ordered_s"]
        assert run["detection_s"] < run["healed_s"]
