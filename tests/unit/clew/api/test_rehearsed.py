"""A fleet in virtual time: waits, faults while it goes on, and the plan that they make."""

import math
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from clew.api import faults
from clew.api.fleet import Fleet, WaitFailedError
from clew.api.launched import launch
from clew.api.rehearsed import RehearsedFleet, asked_of, rehearse
from clew.api.run import EndedRun, open_run
from protocol.errors import UsageError
from protocol.faults.rules import Partition
from tests.support.scenes.world_scenarios import scenario
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE
from world.scenario.scenario import Scenario, load


@pytest.fixture
def fleet(tmp_path: Path) -> Fleet:
    """Three robots in the grove."""
    return launch("grove", robots=3, seed=3, out=tmp_path / "run", stage="rehearsal")


def entries_in(folder: Path) -> list[bytes]:
    """The lines of a log without its header, which has the fault plan."""
    return (folder / EVENTS_FILE).read_bytes().splitlines()[1:]


def test_the_same_calls_give_the_same_bytes_and_their_plan_rehearses_them_again(
    fleet: Fleet, tmp_path: Path
) -> None:
    with fleet:
        fleet.leader.kill(at="after_plan", step=2)
        fleet.until("step.planned", step=1)
        fleet.link(2, 3).drop(0.4)
        with fleet.partition([2], [3]):
            fleet.until("view.proposed")
        fleet.tail.freeze(for_s=1.0)
        fleet.finish()
    assert [rule.fault for rule in fleet.plan.rules] == ["kill", "drop", "partition", "freeze"]
    again = rehearse("grove", robots=3, seed=3, faults=fleet.plan.rules, out=tmp_path / "again")
    assert again.ok
    assert entries_in(tmp_path / "again") == entries_in(tmp_path / "run")


def test_a_wait_gives_each_entry_once_in_order(fleet: Fleet) -> None:
    with fleet:
        first = fleet.until("step.planned")
        second = fleet.until("step.planned", where=lambda entry: entry.step > 0)
        assert (first.step, second.step) == (1, 2)
        run = fleet.finish()
        with pytest.raises(WaitFailedError, match=r"step.planned did not come: the run ended at t=.*arrived"):
            fleet.until("step.planned")
    assert run.ok


def test_a_fault_moves_the_wait_past_what_happened_before(fleet: Fleet) -> None:
    with fleet:
        fleet.until("robot.started", robot="r1")
        assert fleet.until("robot.started").source == "r2"
        with pytest.raises(UsageError, match="must be a robot of the fleet, r1 to r3, got robot3"):
            fleet.until("robot.started", robot="robot3")
        fleet.link(1, 2).drop(0.1)
        with pytest.raises(WaitFailedError):
            fleet.until("robot.started", timeout_s=0.5)  # r3 has started before the fault


def test_a_partition_heals_when_the_block_is_left_whatever_happens(fleet: Fleet) -> None:
    with fleet:
        fleet.until("step.planned", step=1)
        with pytest.raises(WaitFailedError), fleet.partition([1], [2, 3]):
            fleet.until("goal.reached", timeout_s=1.0)
        [cut] = [rule for rule in fleet.plan.rules if isinstance(rule, Partition)]
        assert cut.until_s == fleet.now_s
        assert fleet.finish().ok


def test_a_wait_has_a_limit_in_simulated_time(fleet: Fleet) -> None:
    with (
        fleet,
        pytest.raises(WaitFailedError, match=r"router.lost of robot 1 did not come: [23]\.\d simulated"),
    ):
        fleet.until("router.lost", robot=1, timeout_s=2.0)
    assert fleet.now_s < 3.0


def test_a_thaw_of_a_robot_that_was_never_frozen_has_not_struck(fleet: Fleet) -> None:
    fleet.inject(faults.thaw(2, from_s=1.0))
    with fleet:
        verdict = fleet.finish().verdict
    assert verdict is not None
    assert (verdict.unstruck, fleet.run.faults) == (("thaw-1",), [])


def test_a_fleet_that_is_left_early_is_stopped_and_judged(fleet: Fleet) -> None:
    with fleet:
        fleet.until("step.planned", step=1)
    run = open_run(fleet.asked.folder)
    assert run.verdict is not None
    assert (run.verdict.reason, run.verdict.violations) == ("the run was told to end", 0)
    assert fleet.is_over


def test_a_fleet_that_never_begins_leaves_nothing(fleet: Fleet) -> None:
    with fleet:
        fleet.tail.kill()
    for late in (lambda: fleet.run, fleet.finish, lambda: fleet.until("step.planned")):
        with pytest.raises(UsageError, match="the fleet was ended before it began"):
            late()
    assert not fleet.asked.folder.exists()


@pytest.mark.parametrize("timeout_s", [-1, math.nan, "soon", None])
def test_a_time_that_nobody_can_wait_is_a_mistake_of_the_test_and_no_finding(
    fleet: Fleet, timeout_s: float
) -> None:
    with fleet, pytest.raises(UsageError, match=r"timeout_s: must be >= 0 .simulated s., got"):
        fleet.until("step.planned", timeout_s=timeout_s)


def test_what_a_live_fleet_refuses_a_rehearsed_one_refuses(fleet: Fleet) -> None:
    with fleet:
        with pytest.raises(UsageError, match="must be a robot of the fleet, r1 to r3, got 4"):
            fleet.robot(4)
        with pytest.raises(UsageError, match="must be a robot of the fleet, r1 to r3, got r4"):
            fleet.link(1, 4).drop()
        with pytest.raises(UsageError, match="link: must be between two robots, got r2 twice"):
            fleet.link(2, "r2")
        planned = fleet.link(1, 2).drop(0.1)
        fleet.until("step.planned", step=1)
        with pytest.raises(UsageError, match="give it before the fleet begins"):
            fleet.leader.kill(at="after_plan")
        with pytest.raises(UsageError, match="give it before the fleet begins"):
            fleet.link(1, 2).drop(0.1, until_s=9.0)
        for window in ({"step": 99}, {"from_s": 99.0}, {"until_s": 0.1}):  # none would be missed as unstruck
            with pytest.raises(UsageError, match="kill: windows and points are for plans"):
                fleet.robot(2).kill(**window)
        with pytest.raises(UsageError, match="drop-2 is a rule of the plan"):
            planned.end()
        fleet.tail.kill()
        fleet.until("fault.injected")
        with pytest.raises(UsageError, match="r3 is dead"):
            fleet.robot("r3").freeze()
        with pytest.raises(UsageError, match="r2 is not frozen"):
            fleet.robot(2).thaw()
        lost, later = (fleet.link(1, 2, one_way=True).drop() for _ in range(2))
        assert (lost.name, later.name) == ("given-2", "given-3"), "no refusal has used a name up"
        lost.end()
        with pytest.raises(UsageError, match=r"no rule given-2 for messages is active"):
            lost.end()
        fleet.finish()
        with pytest.raises(UsageError, match="kill: the run is over"):
            fleet.robot(2).kill()


def test_each_target_and_each_kind_of_fault_strikes(tmp_path: Path) -> None:
    with launch("grove", robots=4, out=tmp_path / "run", stage="rehearsal") as fleet:
        fleet.until("step.planned", step=1)
        fleet.link(1, 2).delay(0.2)
        fleet.link(1, 2).duplicate()
        fleet.link(2, 3).corrupt(0.2)
        fleet.middle.slow(by_s=0.2, for_s=1.0)
        fleet.until("step.planned", step=2)
        fleet.router.restart(after_s=0.2)
        fleet.until("router.found")
        fleet.coordinator.freeze(for_s=0.3)
        fleet.world.freeze(for_s=0.3)
        run = fleet.finish()
    struck = {(entry.fault, entry.process) for entry in run.faults}
    assert {"delay", "duplicate", "corrupt", "slow", "kill", "start", "freeze", "thaw"} <= {
        fault for fault, _ in struck
    }
    assert {"router", "world"} <= {process for _, process in struck}
    assert run.verdict is not None
    assert run.verdict.violations == 0


def test_a_fault_that_is_left_out_keeps_the_draws_of_the_others(tmp_path: Path) -> None:
    asked = asked_of(
        "grove", robots=3, seed=1, faults=[faults.kill(3), faults.drop(p=0.1)], out=tmp_path / "run"
    )
    left = RehearsedFleet(replace(asked, without=frozenset({1})))
    assert (left.plan.names, left.given_count) == (["drop-2"], 2)


def test_a_scenario_of_ones_own_is_rehearsed(tmp_path: Path) -> None:
    mine: Scenario = load("grove")
    run = rehearse(mine, robots=2, out=tmp_path / "run")
    assert (run.ok, run.scenario.fleet.robots) == (True, 2)
    assert scenario().fleet.robots == rehearse(scenario(), out=tmp_path / "bare").scenario.fleet.robots


def test_a_run_that_meets_its_time_limit_is_judged(tmp_path: Path) -> None:
    grove = load("grove", robots=1)
    run = rehearse(
        msgspec.structs.replace(grove, time=type(grove.time)(time_s_max=2.0)), out=tmp_path / "run"
    )
    assert run.verdict is not None
    assert run.verdict.reason.startswith("the time was up")


def test_without_a_folder_the_run_is_the_latest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    run = rehearse("grove", robots=1)
    assert open_run("runs/latest").folder == run.folder
    assert run.folder.parent == tmp_path / "runs"


@pytest.mark.parametrize("where", ["grove", load("grove")])
def test_a_run_has_the_time_that_is_asked_for(tmp_path: Path, where: str | Scenario) -> None:
    run = rehearse(where, robots=2, time_s_max=2.0, out=tmp_path / "run")
    assert run.verdict is not None
    assert run.scenario.time.time_s_max == 2.0
    assert run.verdict.sim_s == pytest.approx(2.0, abs=0.1)
    with pytest.raises(UsageError, match=r"\$\.time\.time_s_max: must be > 0\.0 s, got -1"):
        rehearse(where, time_s_max=-1, out=tmp_path / "refused")


def test_a_wrong_stage_speed_or_scenario_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="unknown scenario 'groove'"):
        rehearse("groove")
    with pytest.raises(
        UsageError, match="law and deployment are for scenarios that are given by their names"
    ):
        rehearse(load("grove"), law="printed")
    with pytest.raises(UsageError, match=r"\$.fleet.robots: must be >= 1, got 0"):
        rehearse(scenario(), robots=0)
    with pytest.raises(UsageError, match=r"speed: must be max or a number in \(0, 1000\], got 'fast'"):
        launch("grove", speed="fast", out=tmp_path)  # type: ignore[arg-type] # as it may be given


def test_a_wait_for_a_step_that_does_not_exist_is_refused_at_once(tmp_path: Path) -> None:
    with (
        launch("grove", robots=1, out=tmp_path / "run", stage="rehearsal") as fleet,
        pytest.raises(UsageError, match=r"^step: must be an integer, 0 or more, got '2'$"),
    ):
        fleet.until("step.planned", step="2")  # type: ignore[arg-type] # as it may be given
    assert not fleet.has_begun


def test_a_wait_for_a_kind_that_does_not_exist_is_refused_at_once(tmp_path: Path) -> None:
    with (
        launch("grove", robots=1, out=tmp_path / "run", stage="rehearsal") as fleet,
        pytest.raises(UsageError, match=r"no kind 'leader.suceeded'; did you mean 'leader.succeeded'"),
    ):
        fleet.until("leader.suceeded")
    assert not fleet.has_begun


def test_a_run_that_has_ended_has_a_verdict_that_need_not_be_asked_for(tmp_path: Path) -> None:
    """That nothing comes before the first line is held by the check of types."""
    run = rehearse("grove", robots=1, out=tmp_path / "run")
    assert run.verdict.violations == 0
    (run.folder / VERDICT_FILE).unlink()
    assert open_run(run.folder).verdict is None
    with pytest.raises(UsageError, match="the run has ended, and its verdict cannot be read"):
        _ = EndedRun(run.folder).verdict
