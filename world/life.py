"""The shell of the world of one fleet: its session, its files, the wall clock. It decides nothing.

Rule 1: an entry of the world is written before any message that depends on it is sent.
Rule 2: the timeline is read back as it is written. The world judges what stands in the file, and the verdict
        says what does not stand there.
Rule 3: a turn takes messages for `TAKE_WALL_S` at most; the rest waits. So however much a robot says, the
        clock goes on, and a stop and a request to end are heard.
"""

import logging
import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from protocol.arrays import Floats
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.faults.process_commands import send_process_fault
from protocol.faults.process_faults import ProcessAction
from protocol.faults.rules import Rule
from protocol.fence import NOBODY_NUMBER, Raise, Release, Stop, Turn
from protocol.keys import WORLD, robot_name, robot_number
from protocol.network.faulty_transport import Conditions, FaultyTransport
from protocol.network.session import Session
from protocol.network.transport import Appeared, Arrival, Asked, Heard, Listed, Refused, Transport, Vanished
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import Entry, Record
from protocol.wire.messages import Drive, LogBatch, Logged, Message, Phase, ScanQuery
from world.closing import Circumstances, verdict_of
from world.commands import Command, Note, ServeScan, TellOdometry
from world.core import World
from world.events import (
    EntryRead,
    EntryWritten,
    Event,
    FencePut,
    MessageDropped,
    OrderHeard,
    ScanAsked,
    StopAsked,
)
from world.faults import RunFaults
from world.geometry.rays import NearDiscs
from world.judge.verdict import Verdict
from world.pace import Pace
from world.record.progress import progress
from world.record.readback import Readback
from world.record.recorder import Recorder
from world.record.resume import Past
from world.scenario.scenario import Scenario

log = logging.getLogger("world")

STRUCK_S = 0.2  # wall: the launcher acts within about 5 ms
CHECK_WALL_S = 0.5  # a folder that was removed is noticed within a second
TAKE_WALL_S = 0.1  # a stop needs five turns to be read and answered


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """The user's request for a run."""

    scenario: Scenario
    session: Session
    out: Path
    seed: int
    speed: float | None
    held: bool = False
    lifeline: int | None
    plan: Plan = NO_FAULTS
    private: Path
    """The run's private folder, with the sockets and pipes of hosts and launcher."""
    resume: bool = False
    """Resume from the timeline in `out`, if there is one."""
    fleet: str = ""
    """The name of the fleet, where several share one ground."""


class Life:
    """The shell of the world of one fleet: its session and its files."""

    def __init__(
        self,
        request: Request,
        transport: Transport,
        recorder: Recorder,
        readback: Readback,
        started_at: str,
        *,
        faults: RunFaults,
        past: Past | None,
    ) -> None:
        self.fleet = request.fleet
        """Its name, where several share one ground."""
        self.verdict: Verdict | None = None
        """The verdict; None until the run has been judged."""
        self._request = request
        self._keys = keys = request.session.keys
        robots = range(1, request.scenario.fleet.robots + 1)
        self._drives = {keys.drive(robot_name(robot)): robot for robot in robots}
        """The robot that each key of orders names."""
        conditions = Conditions(request.plan, request.seed, request.speed or 1.0)
        self._transport = FaultyTransport(
            transport, conditions, self._keys, WORLD, lambda fault: self._note(self._world.now_s, fault)
        )
        self._faults, self._recorder, self._readback = faults, recorder, readback
        self._untaken = deque[Arrival]()
        """What has arrived and waits to be handled (rule 3)."""
        self._check_wall_s = 0.0
        """When the run's folder is checked next."""
        self._started_wall_s = self._over_wall_s = now_s = time.monotonic()
        self._past, self._started_at, self._mission = past, started_at, request.scenario.mission()
        self._world = World(
            request.scenario, seed=request.seed, wall_s=now_s, past=past, in_all=request.session.robots
        )
        self._world.arena.follow_scans(request.speed is None and request.scenario.obstacles_move)
        self._pace = Pace(request.speed, self._is_held_up, 0.0 if request.held else math.inf)

    def begin(self) -> None:
        """Begin the run, or resume it."""
        if self._past is not None:
            self._resume(self._past)

    @property
    def is_over(self) -> bool:
        """Whether the run has come to its end; the verdict follows."""
        return self._world.ending is not None

    @property
    def has_started(self) -> bool:
        """Whether the clock may tick."""
        return self._world.started

    @property
    def is_behind(self) -> bool:
        """Whether entries wait to be judged; a resumed world reads all, as fast as its other work allows."""
        return self._readback.is_behind

    @property
    def now_s(self) -> float:
        """Simulated time."""
        return self._world.now_s

    @property
    def places_m(self) -> Floats:
        """Where the bodies are (n, 2) [world frame]."""
        return self._world.bodies.place_m

    @property
    def is_flooded(self) -> bool:
        """Whether messages wait to be handled (rule 3): before that it takes in no others."""
        return len(self._untaken) > 0

    def share_ground(self, others: NearDiscs) -> None:
        """See the hulls of other fleets, too."""
        self._world.arena.share_ground(others)

    def wait_s(self, wall_s: float) -> float:
        """How long until its clock is due [wall s]."""
        return self._pace.wait_s(self._world, wall_s=wall_s)

    async def arrivals(self, wait_s: float) -> Sequence[Arrival]:
        """Wait for messages; it may be cancelled, and then loses none."""
        return await self._transport.arrivals(wait_s)

    def turn(self, arrivals: Sequence[Arrival], asked: ExitCode | None) -> None:
        """Handle what has arrived, and look what follows from it; `asked`: to end, with this exit code."""
        self._untaken.extend(arrivals)
        until_s = time.monotonic() + TAKE_WALL_S
        while self._untaken and time.monotonic() < until_s:
            self._take(self._untaken.popleft())
        if asked is not None:
            self._handle(StopAsked(asked))
        self._read_back()
        world = self._world
        self._obey(world.look(wall_s=time.monotonic(), router=self._transport.router))
        if world.judgement is not None:  # the run has its end: nothing follows
            self._read_back()
            self.verdict = self._pass_verdict()

    def note_turn(self, wall_s: float, *, asked_s: float) -> None:
        """A turn of the loop begins, in which it is asked to wait for so long at most."""
        self._world.answers.lateness.turn(wall_s, self._transport.busy_s, asked_s=asked_s)

    def tick(self) -> None:
        """Advance by one tick."""
        self._obey(self._world.tick())
        self._pace.ticked(self._world, wall_s=time.monotonic())

    def after_ticks(self) -> None:
        """Repeat what may have been lost, and inject the faults that are due."""
        world = self._world
        self._obey(world.remind(self._pace.take_reminder(world, wall_s=time.monotonic())))
        self._note_wall_times()
        self._inject_faults()

    def _read_back(self) -> None:
        """Let the world judge what stands in the timeline: a part of it while the run goes on, else all."""
        if time.monotonic() >= self._check_wall_s:
            self._check_wall_s = time.monotonic() + CHECK_WALL_S
            self._readback.check()
        for source, entry in self._readback.read():
            self._handle(EntryRead(source, entry))
        while self._world.phase is not Phase.RUNNING and self._readback.is_behind:
            for source, entry in self._readback.read():
                self._handle(EntryRead(source, entry))

    def _resume(self, past: Past) -> None:
        """Restore the state that the killed world had recorded."""
        ran_s = (datetime.now(UTC) - datetime.fromisoformat(past.header.started_at)).total_seconds()
        self._obey(self._world.resume(wall_s=time.monotonic()))
        if self._world.started:
            self._started_wall_s -= ran_s

    def _note_wall_times(self) -> None:
        if self._world.ending is None:
            self._over_wall_s = time.monotonic()
            if not self._world.started:
                self._started_wall_s = self._over_wall_s

    def add_fault(self, rule: Rule, for_s: float | None) -> str:
        """Apply a manual fault rule from now on; returns its name.

        Raises:
            UsageError: the run is not active, or the rule is refused.
        """
        self._check_running()
        return self._faults.add(rule, now_s=self._world.now_s, for_s=for_s)

    def end_fault(self, name: str) -> None:
        """End a manual rule for messages.

        Raises:
            UsageError: the run is not active, or no such rule is.
        """
        self._check_running()
        self._faults.end(name, now_s=self._world.now_s)

    def halt(self, *, stop: bool) -> str:
        """Stop the fleet as its operator, or release it; returns what it is now, and its epoch.

        Raises:
            UsageError: the run is not active, or there is nothing to release.
        """
        self._check_running()
        before = self._world.arena.fence
        change = Stop() if stop else Release(generation=before.epoch.generation)
        self._handle(FencePut(NOBODY_NUMBER, change))
        if (fence := self._world.arena.fence) == before and not stop:
            raise UsageError("the fleet is not stopped")
        return f"{'stopped' if stop else 'released'}, epoch {fence.epoch.number}"

    def go(self, for_s: float) -> str:
        """Let a held run go on for so long from now; returns its time.

        Raises:
            UsageError: the run is not held, or not active.
        """
        if not self._request.held:
            raise UsageError("the run is not held: it goes on by itself")
        self._check_running()
        self._pace.go(self._world.now_s + for_s, wall_s=time.monotonic())
        return f"{self._world.now_s:.3f}"

    def _check_running(self) -> None:
        if not self._world.started or self._world.phase is not Phase.RUNNING:
            raise UsageError("the run has not begun, or is over")

    def _inject_faults(self) -> None:
        """Inject the faults that are due, while the run is active; each is recorded first."""
        now_s = self._world.now_s
        self._transport.tell_time(now_s)
        if not self._world.started or self._world.phase is not Phase.RUNNING:
            return
        for fault in self._faults.due(now_s):
            self._note(now_s, fault.as_record())
            if fault.action not in {ProcessAction.SLOW, ProcessAction.UNSLOW}:
                send_process_fault(self._request.private, fault, speed=self._request.speed or 1.0)
            if (fault.process, fault.action) == (WORLD, ProcessAction.FREEZE):
                time.sleep(STRUCK_S)  # so that the world does nothing between its request and its stop
                self._pace.resume()
        self._transport.have(self._faults.of(WORLD))
        for name, faults in self._faults.news(sorted(self._world.attendance.robots), now_s).items():
            self._transport.put(self._keys.fault(name), faults)

    def _is_held_up(self, robot: int) -> bool:
        """Whether a fault keeps a robot from answering in time."""
        name = robot_name(robot)
        return self._transport.hold_up(name) or self._faults.hold_up(name)

    def _take(self, arrival: Arrival) -> None:
        robot = self._drives.get(arrival.key) or self._robot(arrival.key)
        match arrival:
            case Heard(key, message=Drive() as drive) if key in self._drives:
                self._handle(OrderHeard(self._drives[key], drive))
            case Asked(answer=answer) if arrival.key == self._keys.mission():
                answer(self._mission)
            case _ if robot is None:
                self._refuse(arrival)
            case Heard(message=(Raise() | Turn()) as change) if arrival.key == self._keys.fence(
                robot_name(robot)
            ):
                self._handle(FencePut(robot, change))
            case Heard(message=LogBatch() as batch) if arrival.key == self._keys.log(robot_name(robot)):
                self._hear_log(robot, batch)
            case Asked(message=ScanQuery(revolutions=revolutions), answer=answer):
                self._handle(ScanAsked(robot, revolutions), answer)
            case Appeared(key):
                self._handle(TokenCame(robot, self._keys.part(key, 2)))
            case Vanished(key):
                self._handle(TokenWent(robot, self._keys.part(key, 2)))
            case _:
                self._refuse(arrival)

    def _hear_log(self, robot: int, batch: LogBatch) -> None:
        if not self._world.attendance.has_shown(robot, batch.incarnation):
            return  # it sends again until it is acknowledged: its token may come a moment later
        source = robot_name(robot)
        self._write(source, batch.entries, batch.incarnation)
        up_to = self._recorder.up_to(source, batch.incarnation)
        logged = Logged(incarnation=batch.incarnation, up_to=up_to)
        self._transport.put(self._keys.logged(source), logged)

    def _refuse(self, arrival: Arrival) -> None:
        """Record an unexpected arrival in the timeline; the world's own token is expected."""
        match arrival:
            case Refused(key, reason):
                self._handle(MessageDropped(self._keys.behind_root(key), reason))
            case Heard(key, _, message) | Asked(key, message, _):
                reason = f"{type(message).__name__} means nothing on this key"
                self._handle(MessageDropped(self._keys.behind_root(key), reason))
            case Appeared() | Vanished() | Listed():
                pass

    def _robot(self, key: str) -> int | None:
        """The robot of this fleet that a key names."""
        parts = self._keys.behind_root(key).split("/")
        named = parts[2:3] if parts[:2] == ["body", "fence"] else parts[1:2]
        robot = robot_number(named[0]) if named else None
        return robot if robot in self._world.attendance.robots else None

    def _handle(self, event: Event, answer: Callable[[Message], None] | None = None) -> None:
        self._obey(self._world.handle(event, wall_s=time.monotonic()), answer)

    def _obey(self, commands: Sequence[Command], answer: Callable[[Message], None] | None = None) -> None:
        notes: list[Note] = []
        for command in commands:
            if isinstance(command, Note):
                notes.append(command)
                continue
            self._note_all(notes)  # rule 1
            notes = []
            match command:
                case TellOdometry(robot, odometry):
                    self._transport.put(self._keys.odometry(robot_name(robot)), odometry)
                case ServeScan(scan=scan):
                    assert answer is not None, "a scan without a query"
                    answer(scan)
        self._note_all(notes)

    def _note(self, t_s: float, record: Record) -> None:
        self._note_all([Note(t_s, record)])

    def _note_all(self, notes: Sequence[Note]) -> None:
        entries: list[Entry] = []
        for n, note in enumerate(notes, start=self._recorder.up_to(WORLD) + 1):
            entries.append(Entry(n=n, t_s=note.t_s, hlc=self._transport.timestamp(), record=note.record))
        self._write(WORLD, entries)

    def _write(self, source: str, entries: Sequence[Entry], incarnation: str = "") -> None:
        for entry in self._recorder.take(source, entries, incarnation):
            if (sentence := progress(source, entry)) is not None:
                log.info("%s%s", f"{self.fleet}: " if self.fleet else "", sentence)
            self._faults.hear(source, entry)
            self._handle(EntryWritten(source, entry))

    def _pass_verdict(self) -> Verdict:
        return verdict_of(
            self._world,
            Circumstances(
                seed=self._request.seed,
                speed=self._request.speed,
                started_at=self._started_at,
                plan=self._request.plan,
                traffic=None if self._past else self._transport.traffic.counted(self._keys.behind_root),
                recorded=self._readback.read_count,
                missing=self._recorder.missing,
                lost=self._readback.lost(self._recorder.written),
                wall_s=self._over_wall_s - self._started_wall_s,
                speed_reached=self._pace.speed_reached,
                ticks_late=self._pace.late,
                cpu_s=time.process_time(),
            ),
        )
