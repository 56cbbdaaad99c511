"""A log that is cut anywhere: what a world that resumes from it owes to those whom the killed one has told.

A world that was killed when so many bytes stood in the file has told at most what it tells after them. So,
wherever the cut is, the new world has a later fence, a later time and greater numbers than anybody has heard.
Its bodies stand where they were told to be, or further on their way, and a stop is still in force. What
robots send again moves nothing. Each entry that it says is written is in the file, once.
"""

import math
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import msgspec
import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.exit_codes import ExitCode
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.faults.rules import Kill, Restart
from protocol.fence import NOBODY_NUMBER, Fence, May, Release, Stop
from protocol.frames import Point, Pose
from protocol.keys import WORLD
from protocol.timeline import Entry, PoseSampled, RobotSettled, RunEnded
from protocol.wire.messages import Odometry, Phase, Scan
from tests.support.logs.logs import HEADER
from tests.support.long import long
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage
from world.commands import Command, Note, ServeScan, TellOdometry
from world.core import World
from world.events import Event, FencePut, OrderHeard, ScanAsked, StopAsked
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.record.recorder import EVENTS_FILE, Written, line
from world.record.resume import QUIET_S, Past, continue_events, read_past
from world.scenario.scenario import Scenario, load

STOPPED_S, RELEASED_S, END_S = 2.43, 3.31, 6.0
LOSSES = Plan(
    name="losses",
    rules=(Restart(target="leader", from_s=3.5, after_s=0.5), Kill(target="tail", from_s=5.0)),
)
REPEATED = 300  # entries: orders and puts so far back come again
AGAIN_EVERY = 50  # entries: the new world is killed, too, and its log is judged
ROUNDING = 1e-9
Lines = list[tuple[str, Entry]]


@dataclass(frozen=True)
class Said:
    """What the world has told a robot, and how many entries stood in the file by then."""

    count: int
    robot: int
    message: Odometry | Scan


class Watched(Rehearsal):
    """A rehearsal that its operator stops for a while, and of which everything is known."""

    def __init__(self, scenario: Scenario, seed: int, plan: Plan) -> None:
        self.said: list[Said] = []
        self.heard: list[tuple[int, Event]] = []
        """The orders and puts that came, and how many entries stood in the file by then."""
        self.poses: list[list[Pose]] = []
        """Where all bodies were when each entry was written."""
        self.phases: list[Phase] = []
        super().__init__(scenario, seed, plan)
        for now_s in self.ticks():
            if math.isclose(now_s, STOPPED_S + 0.01):
                self._tell_world(FencePut(NOBODY_NUMBER, Stop()))
            if math.isclose(now_s, RELEASED_S + 0.01):
                generation = self.world.arena.fence.epoch.generation
                self._tell_world(FencePut(NOBODY_NUMBER, Release(generation=generation)))

    def _execute_world(self, commands: list[Command]) -> None:
        for command in commands:
            super()._execute_world([command])
            match command:
                case TellOdometry(robot, message) | ServeScan(robot, message):
                    self.said.append(Said(len(self.entries), robot, message))
                case Note():
                    pass

    def _tell_world(self, event: Event) -> None:
        if isinstance(event, OrderHeard | FencePut):
            self.heard.append((len(self.entries), event))
        super()._tell_world(event)

    def _write(self, source: str, t_s: float, record: object) -> None:
        super()._write(source, t_s, record)  # type: ignore[arg-type] # as it came
        bodies = self.world.bodies
        self.poses.append([bodies.pose(body) for body in range(len(bodies))])
        self.phases.append(self.world.phase)


@cache
def watched(name: str, plan: Plan) -> Watched:
    return Watched(load(name, time_s_max=END_S), 1, plan)


class Cut:
    """A new world on the first entries of a run."""

    def __init__(self, scenario: Scenario, lines: Lines) -> None:
        self.past = Past(HEADER, 0, 0, lines)
        self.world = World(scenario, seed=1, wall_s=0.0, past=self.past)
        commands = self.world.resume(wall_s=0.0)
        notes = [command for command in commands if isinstance(command, Note)]
        assert notes == commands, "it tells nobody before the fence is written"
        first = 1 + sum(source == WORLD for source, _ in lines)
        self.lines = [
            *lines,
            *(
                (WORLD, Entry(n=n, t_s=note.t_s, hlc="", record=note.record))
                for n, note in enumerate(notes, start=first)
            ),
        ]

    @property
    def fence(self) -> Fence:
        return self.world.arena.fence

    @property
    def poses(self) -> list[Pose]:
        return [self.world.bodies.pose(body) for body in range(len(self.world.bodies))]


def check(run: Watched, count: int) -> Cut:
    """What a world that resumes from so many entries owes to those who were told something before."""
    cut = Cut(run.world.scenario, run.entries[:count])
    told = [each for each in run.said if each.count <= count]
    if not cut.world.started:
        assert told == []
        return cut
    for each in told:
        assert each.message.fence.key < cut.fence.key
        assert each.message.t_s < cut.world.now_s <= run.world.now_s + QUIET_S + 0.3
    newest = {each.robot: each.message for each in told if isinstance(each.message, Odometry)}
    for robot, odometry in newest.items():
        body = cut.world.bodies[robot - 1]
        after = cut.world.arena.odometry(robot, Phase.RUNNING, stood_s=0.0)
        assert after.n > odometry.n
        assert (body.ordered, body.finished_number) >= (odometry.ordered, odometry.finished)
        assert is_between(cut.world.bodies.pose(robot - 1), odometry.pose, run.poses[count - 1][robot - 1])
    assert (cut.past.fence.may is May.STOPPED) == (cut.fence.may is May.STOPPED)
    assert cut.fence.may in {May.STOPPED, May.NOBODY}
    return cut


def is_between(pose: Pose, told: Pose, live: Pose) -> bool:
    """Whether a body stands where its robot was told, or on its way from there to where it was."""
    off_m = apart_m(told, pose) + apart_m(pose, live) - apart_m(told, live)
    return abs(off_m) < ROUNDING and turned_rad(pose, live) <= turned_rad(told, live) + ROUNDING


def apart_m(one: Pose, other: Pose) -> float:
    return math.hypot(one.x_m - other.x_m, one.y_m - other.y_m)


def turned_rad(one: Pose, other: Pose) -> float:
    return abs(math.remainder(one.heading_rad - other.heading_rad, 2.0 * math.pi))


def come_again(run: Watched, cut: Cut, count: int) -> None:
    """All that robots sent lately comes again, and nothing moves by it."""
    stood = cut.poses
    for at, event in run.heard:
        if count - REPEATED < at <= count and getattr(event, "robot", None) != NOBODY_NUMBER:
            cut.world.handle(event, wall_s=0.0)
            assert cut.fence.may in {cut.past.fence.may, May.NOBODY} & {May.STOPPED, May.NOBODY}
    for _ in range(10):
        cut.world.tick()
    assert cut.poses == stood


CASES = [("follower", LOSSES, 7), *long([("door", LOSSES, 1), ("follower", NO_FAULTS, 1)])]


@pytest.mark.parametrize(("name", "plan", "every"), CASES)
def test_a_world_that_was_killed_after_any_entry_goes_on_from_what_it_had_told(
    name: str, plan: Plan, every: int
) -> None:
    run = watched(name, plan)
    stopped = 0
    for count in range(1, run.phases.index(Phase.OVER) + 1, every):
        cut = check(run, count)
        stopped += cut.fence.may is May.STOPPED
        come_again(run, cut, count)
    assert stopped > 0


def test_a_world_that_is_killed_while_it_resumes_goes_on_from_the_same_state() -> None:
    run = watched("follower", LOSSES)
    for count in range(AGAIN_EVERY, run.phases.index(Phase.OVER), AGAIN_EVERY):
        cut = check(run, count)
        for more in range(count, len(cut.lines) + 1):
            again = Cut(run.world.scenario, cut.lines[:more])
            assert again.poses == cut.poses
            assert again.fence.key >= cut.fence.key
            assert again.fence.may is cut.fence.may
            assert again.world.now_s >= cut.world.now_s
            assert judge(run.world.scenario, again.lines).breaches == ()
            times_s = [entry.t_s for source, entry in again.lines if source == WORLD]
            assert times_s == sorted(times_s)


@pytest.mark.parametrize("every", [23, *long([1])])
def test_of_a_file_that_is_cut_at_any_byte_exactly_the_whole_lines_are_kept(
    tmp_path: Path, every: int
) -> None:
    lines = watched("follower", LOSSES).entries[:30]
    header = msgspec.json.encode(HEADER) + b"\n"
    texts = [header, *(line(source, entry) for source, entry in lines)]
    text, path = b"".join(texts), tmp_path / EVENTS_FILE
    for size in range(0, len(text) + 1, every):
        path.write_bytes(text[:size])
        written = Written()
        past = read_past(tmp_path, written.recall)
        whole = text[:size].count(b"\n")
        if whole == 0:
            assert (past, path.exists()) == (None, False)
            continue
        assert past is not None
        kept = b"".join(texts[:whole])
        assert (past.count, past.whole_bytes, past.torn_bytes) == (whole - 1, len(kept), size - len(kept))
        assert written.counts == Counter(source for source, _ in lines[: whole - 1])
        continue_events(tmp_path, past.whole_bytes).close()
        assert path.read_bytes() == kept


def test_a_sample_of_a_resumed_world_compares_a_body_with_others_where_they_stand_now() -> None:
    stage = Stage(scenario())
    stage.begin()
    stage.lead(1, Point(x_m=1.0, y_m=0.0))
    stage.order(2, Point(x_m=0.0, y_m=0.0))
    stage.tick(52)
    for robot in (1, 2):
        stage.handle(ScanAsked(robot, 1))  # their places are known by the scans, and are sampled
    apart_m = stage.world.bodies.places[0][0] - stage.world.bodies.places[1][0]
    samples = [each for each in stage.resumed().records if isinstance(each, PoseSampled)]
    assert [each.separation_m for each in samples] == [pytest.approx(apart_m - 0.2)] * 4


def test_a_world_that_only_passes_the_verdict_knows_when_the_run_was_over() -> None:
    stage = Stage(scenario())
    stage.begin()
    stage.tick(30)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    over_s = stage.world.now_s
    for robot in (1, 2):
        stage.write(robot, RobotSettled(sent={}))
    stage.tick(50, awake=False)
    stage._write(WORLD, stage.world.now_s, RunEnded(reason=str(Ending.INTERRUPTED)))
    assert stage.resumed().world.over_s == over_s
