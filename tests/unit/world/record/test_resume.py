"""A killed world is resumed from its timeline: the restored state, and the view of the robots."""

import json
import os
import signal
from pathlib import Path

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.fence import NUMBERS, Cause, Fence, May, Raise, Release, Stop, Turn
from protocol.frames import Point
from protocol.process.tokens import TokenCame
from protocol.timeline import (
    Entry,
    FenceChanged,
    OrderFinished,
    PoseSampled,
    PromiseBroken,
    RobotArrived,
    RobotStarted,
    RunEnded,
    TrafficCounted,
    WorldResumed,
)
from protocol.wire.messages import Odometry, Phase
from tests.support.campaigns import clew
from tests.support.logs.logs import AT_REST, HEADER, numbered, recorded
from tests.support.long import long
from tests.support.processes.fleets import Fleet
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage, life_of
from tests.support.strategies.examples import examples
from world.attendance import SILENCE_S
from world.bodies.arena import TICK_S
from world.events import ScanAsked, StopAsked
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.record import resume
from world.record.recorder import EVENTS_FILE, Recorder, Written, open_events
from world.record.resume import QUIET_S, continue_events, read_past

SECOND = round(1.0 / TICK_S)
FAR = Point(x_m=1.0, y_m=0.0)


def led(*, ticks: int) -> Stage:
    """A run in which robot 1 has driven towards `FAR` for this time."""
    stage = Stage(scenario())
    stage.begin()
    stage.lead(1, FAR)
    stage.tick(ticks)
    return stage


def told(stage: Stage) -> Odometry:
    """The last odometry of robot 1."""
    return stage.odometry[1][-1]


def first_told(stage: Stage) -> Odometry:
    """The first odometry of robot 1 from a resumed world."""
    while not stage.odometry[1]:
        stage.tick(awake=False)
    return stage.odometry[1][0]


# --- the robots' view -----------------------------------------------------------------------------


@settings(max_examples=examples(25), deadline=None)
@given(ticks=st.integers(0, 3 * SECOND))
def test_a_world_killed_at_any_point_resumes_with_later_times_and_the_bodies_where_robots_saw_them(
    ticks: int,
) -> None:
    before = led(ticks=ticks)
    last = told(before)
    after = before.resumed()
    now = first_told(after)
    assert now.t_s > last.t_s
    assert now.t_s <= before.world.now_s + QUIET_S + 0.3
    assert (now.finished, now.ordered) == (before.world.bodies[0].finished_number, 1)
    # Its place at the last odometry, or at a later record.
    assert last.pose.x_m - 1e-9 <= now.pose.x_m <= before.world.bodies.pose(0).x_m + 1e-9


@settings(max_examples=examples(25), deadline=None)
@given(ticks=st.integers(0, 3 * SECOND), again=st.integers(0, SECOND))
def test_the_log_of_both_worlds_has_no_violation_and_no_body_jumps(ticks: int, again: int) -> None:
    stage = led(ticks=ticks).resumed()
    stage.tick(again)
    stage = stage.resumed()
    stage.tick(3 * SECOND)
    judgement = judge(stage.world.scenario, stage.lines)
    assert judgement.breaches == ()
    assert judgement.path_m == pytest.approx(stage.world.bodies.pose(0).x_m)  # no part is driven twice


def test_time_continues_after_a_long_quiet_period() -> None:
    before = Stage(scenario())
    before.begin()
    before.tick(20 * SECOND, awake=False)
    assert first_told(before.resumed()).t_s > told(before).t_s


def test_a_resumed_world_raises_the_fence_before_it_obeys_or_tells_anything() -> None:
    before = led(ticks=SECOND)
    stage = before.resumed()
    (changed,) = [each for each in stage.records if isinstance(each, FenceChanged)]
    assert (changed.cause, changed.epoch, changed.may) == (Cause.WORLD_RESTARTED, 2 * NUMBERS, May.NOBODY)
    assert stage.odometry == {1: [], 2: []}
    now = first_told(stage)
    assert now.fence.epoch == before.fence.epoch.next(0, 0)
    assert now.n > told(before).n


def test_an_order_from_before_the_restart_drives_no_body_however_often_it_is_repeated() -> None:  # V7, V15
    before = led(ticks=SECOND)
    old = before.bearing(1)
    stage = before.resumed()
    stage.tick(awake=False)
    refused = stage.order(1, FAR, step=1, bearing=old)  # the one in hand, by its number
    assert [type(each).__name__ for each in refused] == ["OrderRefused"]
    stage.tick(2 * SECOND, awake=False)
    assert told(stage).pose.x_m == pytest.approx(0.5, abs=0.1)
    assert (told(stage).finished, told(stage).moving) == (0, False)
    stage.form()
    stage.order(1, FAR, number=2, step=1)
    stage.tick(2 * SECOND)
    assert told(stage).pose.x_m == pytest.approx(1.0)
    assert told(stage).finished == 2


def test_puts_from_before_the_restart_change_nothing() -> None:
    before = Stage(scenario())
    before.begin()
    epoch = before.fence.epoch.next(2, life_of(2))
    before.put(2, Raise(epoch=epoch, cause=Cause.NEIGHBOUR_LOST))
    stage = before.resumed()
    late = Turn(fence=Fence(epoch=epoch, turn=1, may=May.ALL, robot=2, members=2))
    assert stage.put(2, late) == []


def test_a_fleet_that_was_stopped_stays_stopped() -> None:
    before = led(ticks=SECOND)
    before.put(0, Stop())
    stage = before.resumed().resumed()
    assert (stage.fence.may, stage.fence.epoch.generation) == (May.STOPPED, 4)
    assert stage.put(0, Release(generation=4)) != []


def test_a_finished_order_is_not_driven_again() -> None:
    stage = led(ticks=4 * SECOND).resumed()
    assert (first_told(stage).finished, first_told(stage).moving) == (1, False)
    stage.tick(SECOND)
    assert not any(isinstance(record, OrderFinished) for record in stage.records)


def test_a_place_known_only_from_a_scan_is_sampled_with_the_time_of_the_scan() -> None:
    before = led(ticks=SECOND + 2)
    before.handle(ScanAsked(1, 1))
    shown_s, shown = before.world.now_s, before.scans[-1].pose
    times_s = [
        (entry.t_s, entry.record.x_m)
        for _, entry in before.resumed().lines[len(before.lines) :]
        if isinstance(entry.record, PoseSampled) and entry.record.robot == 1
    ]
    assert times_s[0] == (shown_s, shown.x_m)
    assert [x_m for _, x_m in times_s] == [shown.x_m] * 2


# --- restored state -------------------------------------------------------------------------------


def test_robots_that_had_come_and_arrived_need_not_do_so_again() -> None:
    before = led(ticks=SECOND)
    before.write(1, RobotStarted(pid=1, incarnation="a"))
    before.write(2, RobotArrived(progress_m=0.0))
    after = before.resumed()
    assert after.handle(TokenCame(1, "a")) == []
    assert after.world.tally.arrived == {2}
    assert after.at()[0]


@pytest.mark.parametrize(
    ("asked", "ending"),
    [(ExitCode.TERMINATED, Ending.TERMINATED), (ExitCode.FAILED, Ending.LOST_PROCESS)],
)
def test_a_resumed_run_waits_for_the_tokens_of_living_robots_before_its_end(
    asked: ExitCode, ending: Ending
) -> None:
    after = led(ticks=SECOND).resumed()
    after.look()
    after.handle(StopAsked(asked))
    assert after.at()[1:] == (Phase.OVER, ending)
    arrived = led(ticks=SECOND)
    for robot in (1, 2):
        arrived.write(robot, RobotArrived(progress_m=0.0))
    arrived = arrived.resumed()
    arrived.look()
    assert arrived.at()[2] is None
    for robot in (1, 2):
        arrived.handle(TokenCame(robot, "a"))
    arrived.look()
    assert arrived.at()[2] is Ending.ARRIVED


def test_a_robot_that_ended_as_told_when_the_run_was_over_has_not_died() -> None:
    before = led(ticks=SECOND)
    for robot in (1, 2):
        before.write(robot, RobotArrived(progress_m=0.0))
    before.write(1, TrafficCounted(sent={}, received={}, newest={}, refused={}, overflowed=0, unrecorded=0))
    after = before.resumed()
    after.handle(TokenCame(2, "a"))
    after.look(after_wall_s=SILENCE_S)
    assert after.at()[2] is Ending.ARRIVED
    assert after.world.attendance.dead == set()


def test_a_world_that_died_before_its_verdict_only_passes_the_verdict() -> None:
    before = led(ticks=SECOND)
    before.write(1, RobotArrived(progress_m=0.0))
    before.lines.append(
        ("world", Entry(n=9999, t_s=9.0, hlc="", record=RunEnded(reason=str(Ending.ARRIVED))))
    )
    after = before.resumed()
    after.look()
    assert after.world.judgement is not None
    assert after.at()[2] is Ending.ARRIVED
    assert after.records == []


def test_a_resumed_world_does_not_record_a_violation_again() -> None:
    before = led(ticks=SECOND)
    before.order(2, Point(x_m=-1.0, y_m=0.0))  # its body was never scanned
    before.look()
    after = before.resumed()
    after.look(after_wall_s=SILENCE_S)
    recorded = [each.record.invariant for _, each in after.lines if isinstance(each.record, PromiseBroken)]
    assert recorded == ["F6"]


def test_each_life_has_its_own_number() -> None:
    stage = led(ticks=SECOND).resumed().resumed()
    lives = [each.record.life for _, each in stage.lines if isinstance(each.record, WorldResumed)]
    assert lives == [1, 2]


# --- the file -------------------------------------------------------------------------------------


@settings(max_examples=examples(30), deadline=None)
@given(cut=st.integers(1, 200))
def test_an_incomplete_line_is_removed_and_numbers_continue(
    tmp_path_factory: pytest.TempPathFactory, cut: int
) -> None:
    folder = recorded(tmp_path_factory.mktemp("run"), numbered(AT_REST))
    path = folder / EVENTS_FILE
    text = path.read_bytes()
    path.write_bytes(text[:-cut])
    written = Written()
    past = read_past(folder, written.recall)
    assert past is not None
    assert past.count == path.read_bytes().count(b"\n") - 1
    assert past.torn_bytes == len(path.read_bytes()) - past.whole_bytes
    with continue_events(folder, past.whole_bytes) as file:
        recorder = Recorder(file, None, written)
        n = past.count + 1
        again = Entry(n=n, t_s=9.0, hlc="", record=RunEnded(reason="again"))
        assert recorder.take("world", [again]) == [again]
        assert recorder.take("world", [again]) == []
        assert (recorder.recorded_count, recorder.missing) == (n, {})
    lines = [json.loads(line) for line in path.read_bytes().splitlines()]
    assert [line["n"] for line in lines] == list(range(n + 1))


def test_entries_of_a_recorded_incarnation_are_neither_repeated_nor_lost(tmp_path: Path) -> None:
    started = RobotStarted(pid=7, incarnation="ab")
    lines = [("r1", Entry(n=1, t_s=0.0, hlc="", record=started))]
    written = Written()
    past = read_past(recorded(tmp_path, lines), written.recall)
    assert past is not None
    with continue_events(tmp_path, past.whole_bytes) as file:
        recorder = Recorder(file, None, written)
        more = Entry(n=2, t_s=0.0, hlc="", record=RobotArrived(progress_m=0.0))
        assert recorder.take("r1", [lines[0][1], more], "ab") == [more]


@pytest.mark.parametrize("read_bytes", [1, 100, 1 << 18])
def test_a_past_is_the_same_however_much_of_the_file_is_read_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, read_bytes: int
) -> None:
    monkeypatch.setattr(resume, "READ_BYTES", read_bytes)
    lines = numbered(AT_REST)
    path = recorded(tmp_path, lines) / EVENTS_FILE
    path.write_bytes(path.read_bytes() + b'{"torn')
    heard = list[tuple[str, Entry]]()
    past = read_past(tmp_path, lambda source, _, entry: heard.append((source, entry)))
    assert past is not None
    assert (heard, past.count, past.torn_bytes) == (lines, len(lines), 6)
    assert past.whole_bytes == path.stat().st_size - 6


def test_a_folder_without_a_run_has_nothing_to_resume(tmp_path: Path) -> None:
    assert read_past(tmp_path) is None
    (tmp_path / EVENTS_FILE).write_bytes(msgspec.json.encode(HEADER)[:40])
    assert read_past(tmp_path) is None
    open_events(tmp_path).close()  # possible despite the incomplete header


DEEP = b'{"kind":"run.started","more":' + b"[" * 9999


@pytest.mark.parametrize("text", [b"words", DEEP], ids=["words", "deep"])
def test_an_invalid_timeline_is_refused(tmp_path: Path, text: bytes) -> None:
    (tmp_path / EVENTS_FILE).write_bytes(text + b"\n")
    with pytest.raises(UsageError, match="no run can go on from it"):
        read_past(tmp_path)


# --- whole fleet ----------------------------------------------------------------------------------


@pytest.mark.processes
@pytest.mark.parametrize("speed", ["max", *long(["2"])])
def test_a_fleet_whose_world_is_killed_arrives_and_nothing_is_missing(fleet: Fleet, speed: str) -> None:
    fleet.start("grove", "-n", "3", "--speed", speed, "--json")
    fleet.wait_for("order.finished")
    os.kill(fleet.process("world"), signal.SIGKILL)
    outcome = fleet.end()
    assert outcome.code == 0, outcome.err
    assert "the world was killed by SIGKILL; it is started again" in outcome.err
    verdict = json.loads(outcome.out)
    assert (verdict["ok"], verdict["violations"], verdict["events"]["missing"]) == (True, 0, 0)
    assert verdict["robots_arrived"] == 3
    assert clew("log", "check", fleet.folder()).exit_code == 0
    assert [each["life"] for each in fleet.entries() if each["kind"] == "world.resumed"] == [1]
    assert fleet.leftovers() == []


@pytest.mark.parametrize("is_reminded", [False, True])
def test_a_pose_that_is_told_between_two_samples_is_recorded_too(is_reminded: bool) -> None:
    stage = led(ticks=43)
    assert stage.world.bodies.is_moving(0)
    if is_reminded:
        stage._obey(stage.world.remind({1}))
    else:
        stage.handle(TokenCame(1, "another"))
    assert stage.resumed().world.bodies.pose(0) == told(stage).pose


def test_a_run_that_was_over_when_its_world_was_killed_serves_no_scan() -> None:
    stage = led(ticks=43)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    while stage.world.judgement is None:
        stage.look(after_wall_s=SILENCE_S)
    again = stage.resumed()
    assert again.handle(ScanAsked(1, 1)) == []
    assert again.scans == []
