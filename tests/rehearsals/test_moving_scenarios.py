"""The three scenarios with moving obstacles: scripted orders to a world, and the judgement."""

from pathlib import Path

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from clew.log import timeline
from clew.log.check import check
from clew.rehearsal.recorded import rehearse
from clew.rehearsal.rehearsal import Rehearsal
from protocol import laws
from protocol.exit_codes import ExitCode
from protocol.faults.plan import Plan, uniform
from protocol.faults.rules import Freeze
from protocol.files.reading import understand
from protocol.frames import Point
from protocol.mission import BRIEF_S
from protocol.timeline import PromiseBroken, StrandReversed
from tests.support.judges import differences
from tests.support.long import long
from tests.support.runs import Runs
from tests.support.scenes.placed import circle, placed
from tests.support.stages.world_stage import Stage
from world.events import ScanAsked, StopAsked
from world.judge.ending import Ending
from world.judge.judgement import Judgement, judge
from world.record.run_files import read_verdict
from world.scenario.scenario import Scenario, load

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
    """The judgement from the log, after a check that it equals the live one."""
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
    """The range of robot 1's ray along +x."""
    stage.handle(ScanAsked(1, 1))
    ranges_m = np.array(stage.scans[-1].ranges_m)
    return float(ranges_m[len(ranges_m) // 2])


@pytest.mark.parametrize("name", ["pedestrian", *long(["follower", "door"])])
def test_log_check_agrees_with_the_verdict(runs: Runs, name: str) -> None:
    run = runs.of(name)
    verdict, finding = read_verdict(run), check(timeline.read(run))
    assert verdict.moving_clearance_m_min is not None
    assert finding.moving_clearance_m_min == verdict.moving_clearance_m_min
    assert finding.clearance_m_min == verdict.clearance_m_min
    assert finding.violations_by_invariant == verdict.violations_by_invariant
    assert finding.flaws == ()


def test_a_robot_that_drives_on_blindly_hits_the_pedestrian() -> None:
    stage = on_stage("pedestrian")
    wait(stage, until_s=2.0)
    drive(stage, 1, 5.0, 2.0)
    assert touched(judged(stage)) == [(1, "in contact with moving obstacle pedestrian while it moved")]


def test_a_robot_that_waits_passes_behind_the_pedestrian() -> None:
    stage = on_stage("pedestrian")
    drive(stage, 1, 2.6, 2.0)
    wait(stage, until_s=8.0)
    assert range_ahead_m(stage) == pytest.approx(4.0)  # it has passed
    drive(stage, 1, 5.0, 2.0)
    judgement = judged(stage)
    assert touched(judgement) == []
    assert 0.0 < judgement.least_moving_clearance.distance_m < 0.5


def test_the_door_is_open_at_the_start_and_closed_before_the_leader_arrives() -> None:
    stage = on_stage("door")
    assert range_ahead_m(stage) == pytest.approx(4.0)
    drive(stage, 1, 2.7, 2.0)
    assert range_ahead_m(stage) == pytest.approx(3.25 - 2.7, abs=0.01)


def test_a_leader_that_drives_on_hits_the_door() -> None:
    stage = on_stage("door")
    drive(stage, 1, 3.4, 2.0)
    assert touched(judged(stage)) == [(1, "in contact with moving obstacle door while it moved")]


def test_the_other_opening_stays_open() -> None:
    stage = on_stage("door")
    drive(stage, 1, 2.6, 2.0)
    for place in ((2.6, 3.5), (3.7, 3.5), (5.0, 2.0)):
        drive(stage, 1, *place)
    assert touched(judged(stage)) == []


@pytest.mark.long  # in the short form a door that cuts a strand in two shows it: `test_dissolving.py`
def test_a_strand_at_the_closed_door_turns_round_once_and_takes_the_other_opening() -> None:
    slow = uniform(delay_s_max=0.1)  # as in a live run at speed 5, where the leader stops further in
    rehearsal = Rehearsal(load("door"), 1, slow).run()
    turns = [entry for _, entry in rehearsal.entries if isinstance(entry.record, StrandReversed)]
    assert rehearsal.world.ending is Ending.ARRIVED
    assert len(turns) == 2, "one to back up, one to lead on"


def test_a_strand_arrives_beside_a_fast_pedestrian_with_more_room_between_its_robots(tmp_path: Path) -> None:
    """With the separation of 0.05 m alone, robots cannot come up to each other: 1 m/s leaves no moment."""
    fast = replace(load("pedestrian"), obstacle_speed_mps_max=1.0)
    assert fast.mission().robot_keep_m == pytest.approx(0.2 + BRIEF_S * 1.0 + 0.01 + 0.01)
    assert load("pedestrian").mission().robot_keep_m == pytest.approx(0.2 + 0.05 + 0.01)
    verdict = rehearse(fast, 1, tmp_path, lambda _: None)
    assert (verdict.ok, verdict.robots_arrived) == (True, 3), verdict.reason
    assert differences(tmp_path) == []


def test_a_child_that_runs_out_from_behind_the_leader_does_not_touch_a_frozen_robot_that_drives_on() -> None:
    """Its last scan shows the leader's hull, and not who stands behind that; the body drives on by it."""
    raw = msgspec.to_builtins(load("pedestrian"))
    raw["fleet"] |= {"robots": 2, "start": [2.1, 2.0, 0.0], "spacing_m": 0.9}
    raw["obstacle"], raw["obstacle_speed_mps_max"] = [], 1.0
    track = [(0.0, 2.3, 2.0), (0.2, 2.3, 2.0), (0.49, 2.1, 2.2), (0.78, 1.88, 2.02), (1.37, 1.3, 2.0)]
    raw["moving"] = [{"id": "child", "shape": "circle", "radius_m": 0.05, "track": track}]
    plan = Plan(name="frozen", rules=(Freeze(target="r2", from_s=0.3, for_s=2.0),))
    rehearsal = Rehearsal(understand(raw, Scenario, "child"), 1, plan)
    for _ in rehearsal.ticks():
        if rehearsal.world.now_s > 3.0:
            rehearsal.stop(ExitCode.INTERRUPTED)
    judgement = judge(rehearsal.world.scenario, rehearsal.entries)
    assert touched(judgement) == []
    assert judgement.path_m > 0.0


def test_the_follower_does_not_catch_up_with_a_robot_that_drives_on() -> None:
    stage = on_stage("follower")
    for robot, x_m in ((1, 5.3), (2, 5.0), (3, 4.7)):
        stage.order(robot, Point(x_m=x_m, y_m=1.5))
    wait(stage, until_s=15.0)
    assert touched(judged(stage)) == []


def test_a_standing_robot_may_be_run_over_and_go_on_afterwards_without_a_violation() -> None:
    stage = on_stage("follower")
    wait(stage, until_s=12.0)
    for robot, y_m in ((1, 1.9), (2, 1.9), (3, 1.9)):
        drive(stage, robot, stage.world.bodies.place_m[robot - 1, 0].item(), y_m)
    assert touched(judged(stage)) == []


def test_a_robot_that_starts_to_move_while_it_is_run_over_breaks_s1() -> None:
    stage = on_stage("follower")
    wait(stage, until_s=3.6)  # the follower is at the tail's place
    drive(stage, 3, 1.2, 2.0)
    assert touched(judged(stage)) == [(3, "in contact with moving obstacle follower while it moved")]


@pytest.mark.long  # in the short form `test_driver.py` shows that no order goes out before a scan permits it
@pytest.mark.parametrize(("name", "seed"), [("door", 3), ("door", 4), ("follower", 4)])
def test_no_body_is_sent_on_its_way_before_its_first_scan_in_an_epoch_even_if_half_of_all_is_lost(
    name: str, seed: int
) -> None:
    rehearsal = Rehearsal(load(name), seed, uniform(loss=0.5)).run()
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()


LID = {
    "id": "lid",
    "shape": "polygon",
    "vertices_m": [(-0.2, -0.025), (0.2, -0.025), (0.2, 0.025), (-0.2, 0.025)],
    "track": [(0.0, -0.18, -1.0), (1.6, -0.18, -0.14), (6.0, -0.18, -0.14), (8.2, -0.18, -1.2)],
}


def test_what_may_be_the_robot_behind_may_hide_more_where_obstacles_move(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """S4: a lid comes to where the follower may be; a post is nearer behind it than behind a hull."""
    monkeypatch.setattr(laws, "_registered", {})
    laws.register("up", lambda seen: seen.step_to((0.0, 0.7 if seen.position[1] < 0.5 else 1.4)))
    scenario = placed(
        "lid",
        [(0.0, 0.0, 1.5708), (-1.0, 0.0, 3.1415)],
        (0.0, 1.4),
        circle((-0.1, -0.42), 0.02),
        law={"law": "up", "epsilon_m": 0.3},
        sensor={"directions": 720},
        drive={"turn_rate_radps": 1.0},
        time={"time_s_max": 20.0},
        moving=[LID],
    )
    rehearsal = Rehearsal(scenario, 1, Plan(name="test", rules=())).run()
    assert judge(scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED
