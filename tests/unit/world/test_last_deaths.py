"""Robots that stop shortly before the end of a run, when nobody has missed them yet.

A fault is recorded before it strikes. What a robot that it has stopped did not tell is lost with that robot.
Of one that stopped by itself, entries are missing.
"""

import pytest

from protocol.faults.plan import NO_FAULTS
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import (
    FaultInjected,
    RobotArrived,
    RobotDied,
    RobotRestarted,
    RobotSettled,
    RunEnded,
    TrafficCounted,
)
from protocol.wire.messages import Phase
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage
from world.closing import Circumstances, verdict_of
from world.core import LAST_WORDS_WALL_S
from world.judge.ending import Ending
from world.judge.verdict import Verdict

CIRCUMSTANCES = Circumstances(
    seed=1,
    speed=1.0,
    started_at="",
    plan=NO_FAULTS,
    traffic=None,
    recorded=0,
    missing={"r1": 3},
    wall_s=0.0,
    cpu_s=0.0,
)
COUNTED = TrafficCounted(sent={}, received={}, newest={}, refused={}, overflowed=0, unrecorded=0)
LAST = 4
"""Entries that are missing where robot 1 is not excused: three that it has sent, and its last one."""


def strikes(fault: str) -> FaultInjected:
    return FaultInjected(fault=fault, rule="rule-1", process="r1")


def arrived(stage: Stage) -> Stage:
    """Both robots have arrived; the run is not over yet."""
    stage.begin()
    stage.tick(50)
    for robot in (1, 2):
        stage.write(robot, RobotArrived(progress_m=1.0))
    return stage


def ended(stage: Stage, *told: int) -> Verdict:
    """The run ends; these robots tell what they have counted."""
    stage.look()
    assert stage.at()[1:] == (Phase.OVER, Ending.ARRIVED)
    for robot in told:
        stage.write(robot, RobotSettled(sent={}))
        stage.write(robot, COUNTED)
    for _ in range(4):
        if stage.world.judgement is None:
            stage.look(after_wall_s=LAST_WORDS_WALL_S)
    return verdict_of(stage.world, CIRCUMSTANCES)


@pytest.mark.parametrize("shows_token", [False, True])
@pytest.mark.parametrize("fault", ["kill", "freeze"])
def test_a_robot_that_a_fault_stops_at_the_last_moment_has_died_and_its_entries_are_not_missing(
    *, fault: str, shows_token: bool
) -> None:
    stage = arrived(Stage(scenario()))
    stage.record(strikes(fault))
    if not shows_token:
        stage.handle(TokenWent(1, "a"))
    verdict = ended(stage, 2)
    ends = [type(each) for each in stage.records if isinstance(each, RobotDied | RunEnded)]
    assert ends == [RobotDied, RunEnded]
    assert [(death.robot, death.ordered) for death in verdict.deaths] == [(1, True)]
    assert (verdict.events.missing, sorted(stage.world.survivors)) == (0, [2])


def test_a_robot_that_dies_by_itself_at_the_last_moment_is_not_excused() -> None:
    stage = arrived(Stage(scenario()))
    stage.handle(TokenWent(1, "a"))
    assert ended(stage, 2).events.missing == LAST
    assert stage.world.survivors == {1, 2}


def test_neither_is_one_that_dies_by_itself_after_a_fault_that_is_over() -> None:
    for over in ("thaw", "start"):
        stage = arrived(Stage(scenario()))
        stage.record(strikes("freeze" if over == "thaw" else "kill"))
        stage.record(strikes(over))
        if over == "start":
            stage.handle(TokenCame(1, "b"))
            assert isinstance(stage.records[-1], RobotRestarted)
            stage.write(1, RobotArrived(progress_m=1.0))
        stage.handle(TokenWent(1, "b" if over == "start" else "a"))
        assert ended(stage, 2).events.missing == LAST


def test_a_killed_robot_is_not_excused_by_a_thaw_nor_by_what_another_robot_says() -> None:
    stage = arrived(Stage(scenario()))
    stage.record(strikes("kill"))
    stage.record(strikes("thaw"))
    assert ended(stage, 2).events.missing == 0
    stage = arrived(Stage(scenario()))
    stage.write(2, strikes("kill"))
    assert ended(stage, 2).events.missing == LAST


def test_a_robot_that_has_told_what_it_counted_before_the_fault_struck_has_not_died() -> None:
    stage = arrived(Stage(scenario()))
    stage.record(strikes("kill"))
    verdict = ended(stage, 1, 2)
    assert (len(verdict.deaths), verdict.events.missing) == (0, 3)
    assert stage.world.survivors == {1, 2}


def test_a_world_that_is_resumed_after_the_end_says_the_same() -> None:
    stage = arrived(Stage(scenario()))
    stage.record(strikes("kill"))
    verdict = ended(stage, 2)
    again = stage.resumed()
    again.look()
    assert verdict_of(again.world, CIRCUMSTANCES).deaths == verdict.deaths
    assert again.world.survivors == {2}
