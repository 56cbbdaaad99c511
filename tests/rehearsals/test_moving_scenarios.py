"""The three scenarios with moving obstacles: scripted orders in a world alone, and how they are judged."""

import numpy as np
import pytest

from clew.log import timeline
from clew.log.check import check
from clew.rehearsal.rehearsal import Rehearsal
from protocol.exit_codes import ExitCode
from protocol.faults.plan import uniform
from protocol.frames import Point
from protocol.timeline import PromiseBroken, StrandReversed
from tests.support.runs import Runs
from tests.support.stages.world_stage import Stage
from world.events import ScanAsked, StopAsked
from world.judge.ending import Ending
from world.judge.judgement import Judgement, judge
from world.record.run_files import read_verdict
from world.scenario.scenario import load

TICKS_PER_S = 50


def on_stage(name: str) -> Stage:
    stage = Stage(load(name))
    stage.begin()
    return stage


def drive(stage: Stage, robot: int, x_m: float, y_m: float) -> None:
    """Order a robot to a place and let it get there."""
    number = stage.odometry[robot][-1].finished + 1
    stage.order(robot, Point(x_m=x_m, y_m=y_m), number=number)
    for _ in range(60 * TICKS_PER_S):
        stage.tick()
        if stage.odometry[robot][-1].finished == number:
            return
    raise AssertionError(f"robot {robot} never got to ({x_m}, {y_m})")


def wait(stage: Stage, *, until_s: float) -> None:
    stage.tick(round((until_s - stage.world.now_s) * TICKS_PER_S))


def judged(stage: Stage) -> Judgement:
    """What the log alone says; that is what was recorded live, too."""
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    judgement = judge(stage.world.scenario, stage.lines)
    live = {entry.record.why for _, entry in stage.lines if isinstance(entry.record, PromiseBroken)}
    assert live == {breach.broken.why for breach in judgement.breaches if breach.broken.invariant == "S1"}
    return judgement


def touched(judgement: Judgement) -> list[tuple[int, str]]:
    return [
        (breach.broken.robot, breach.broken.why)
        for breach in judgement.breaches
        if breach.broken.invariant == "S1"
    ]


def range_ahead_m(stage: Stage) -> float:
    """How far the ray of robot 1 gets that points along +x."""
    stage.handle(ScanAsked(1, 1))
    ranges_m = np.array(stage.scans[-1].ranges_m)
    return float(ranges_m[len(ranges_m) // 2])


@pytest.mark.parametrize("name", ["pedestrian", "door", "follower"])
def test_checking_the_log_comes_to_the_same_as_the_verdict(runs: Runs, name: str) -> None:
    run = runs.of(name)
    verdict, finding = read_verdict(run), check(timeline.read(run))
    assert verdict.moving_clearance_m_min is not None
    assert finding.moving_clearance_m_min == verdict.moving_clearance_m_min
    assert finding.clearance_m_min == verdict.clearance_m_min
    assert finding.violations_by_invariant == verdict.violations_by_invariant
    assert finding.flaws == ()


def test_who_walks_on_blindly_meets_the_pedestrian() -> None:
    stage = on_stage("pedestrian")
    wait(stage, until_s=2.0)
    drive(stage, 1, 5.0, 2.0)
    assert touched(judged(stage)) == [(1, "in contact with moving obstacle pedestrian while it moved")]


def test_who_waits_for_the_pedestrian_passes_behind_it() -> None:
    stage = on_stage("pedestrian")
    drive(stage, 1, 2.6, 2.0)
    wait(stage, until_s=8.0)
    assert range_ahead_m(stage) == pytest.approx(4.0)  # it has passed
    drive(stage, 1, 5.0, 2.0)
    judgement = judged(stage)
    assert touched(judgement) == []
    assert 0.0 < judgement.least_moving_clearance.distance_m < 0.5


def test_the_door_is_open_when_the_leader_sets_out_and_closed_before_it_is_there() -> None:
    stage = on_stage("door")
    assert range_ahead_m(stage) == pytest.approx(4.0)
    drive(stage, 1, 2.7, 2.0)
    assert range_ahead_m(stage) == pytest.approx(3.25 - 2.7, abs=0.01)


def test_the_leader_that_drives_on_runs_into_the_door() -> None:
    stage = on_stage("door")
    drive(stage, 1, 3.4, 2.0)
    assert touched(judged(stage)) == [(1, "in contact with moving obstacle door while it moved")]


def test_the_other_opening_stays_open() -> None:
    stage = on_stage("door")
    drive(stage, 1, 2.6, 2.0)
    for place in ((2.6, 3.5), (3.7, 3.5), (5.0, 2.0)):
        drive(stage, 1, *place)
    assert touched(judged(stage)) == []


def test_a_strand_before_the_closed_door_turns_round_once_and_takes_the_other_opening() -> None:
    slow = uniform(delay_s_max=0.1)  # as live at five times real time, where the leader stops further in
    rehearsal = Rehearsal(load("door"), 1, slow).run()
    turns = [entry for _, entry in rehearsal.entries if isinstance(entry.record, StrandReversed)]
    assert rehearsal.world.ending is Ending.ARRIVED
    assert len(turns) == 2, "to back up, and to lead on"


def test_the_follower_does_not_catch_up_with_a_robot_that_drives_on() -> None:
    stage = on_stage("follower")
    for robot, x_m in ((1, 5.3), (2, 5.0), (3, 4.7)):
        stage.order(robot, Point(x_m=x_m, y_m=1.5))
    wait(stage, until_s=15.0)
    assert touched(judged(stage)) == []


def test_the_follower_may_run_over_a_robot_that_stands_and_the_robot_may_go_on_when_it_has_passed() -> None:
    stage = on_stage("follower")
    wait(stage, until_s=12.0)
    for robot, y_m in ((1, 1.9), (2, 1.9), (3, 1.9)):
        drive(stage, robot, stage.world.bodies.place_m[robot - 1, 0].item(), y_m)
    assert touched(judged(stage)) == []


def test_a_robot_that_sets_off_while_it_is_run_over_breaks_its_promise() -> None:
    stage = on_stage("follower")
    wait(stage, until_s=3.6)  # the follower is at the tail's place
    drive(stage, 3, 1.2, 2.0)
    assert touched(judged(stage)) == [(3, "in contact with moving obstacle follower while it moved")]
