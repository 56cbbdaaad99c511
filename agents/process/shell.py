"""The shell of one robot: its session, its clock, its end. It decides nothing about driving.

Rule 1: among messages that arrive together, the newest odometry sets the time first. So a robot that was
        frozen knows how late it is before it handles anything else.
Rule 2: timeline entries are repeated until the recorder has them, and the robot does not end before that.
        They are sent before the core's messages, so that others only react to what is on record.
Rule 3: time in which the process did not run does not count as silence of the world.
        The process says with every order how late it runs, so that the world can slow down.
Rule 4: a robot injects a fault at a point of its step into itself. That happens after the core has decided,
        when the planned step is recorded and nothing else has been executed.
"""

import os
import secrets
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from msgspec.structs import replace

from agents.commands import AskScan, Command, Note, Order, Put, Say, Tell
from agents.events import Event
from agents.process.asking import Asking
from agents.process.endless_law import watch_law
from agents.process.failure import failed
from agents.process.hearing import event_for, heard, listed, tokens_of
from agents.process.journal import Given, Head, Journal, decided, open_journal
from agents.process.points import is_plan
from agents.process.victim import Victim
from agents.process.watching import at_once, beside, watched_by
from agents.robot import Robot
from protocol.errors import SessionLostError, UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.process_faults import ProcessFault
from protocol.fence import LIFE_BITS
from protocol.keys import WORLD, WORLD_NUMBER, robot_name, robot_number
from protocol.laws import find
from protocol.mission import Mission, start_wall_s
from protocol.network.faulty_transport import Conditions, FaultyTransport
from protocol.network.lateness import Lateness
from protocol.network.outbox import Outbox, resend_s
from protocol.network.session import Session
from protocol.network.traffic import in_parts
from protocol.network.transport import Appeared, Arrival, Heard, Listed, Refused, Transport, Vanished
from protocol.network.zenoh_transport import open_transport
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import MessageRefused, Record, RobotFailed, RobotSettled, RobotStarted, TrafficCounted
from protocol.wire.messages import (
    Ask,
    Logged,
    Odometry,
    Phase,
    ScanQuery,
)

TURN_S = 0.1  # wall: the period of the outbox when nothing arrives
TURN_S_PER_ROBOT = 0.001  # a thousand robots that wait cost as much as a hundred
WORLD_SILENCE_S = 60.0  # wall: docs/run.md; longer than any partition that a fleet must survive
LOOK_S_MAX = 1.0  # wall: a longer pause than ten turns is our own, not the world's silence
FAULT_PATIENCE_S = 5.0  # wall: after this, a fault is injected even if it is not recorded
CLOSING_PATIENCE_S = 10.0  # wall: a world that was killed is back long before; docs/run.md


async def run(
    robot: int,
    session: Session,
    *,
    conditions: Conditions,
    sessions: Path,
    again: bool,
    on_connected: Callable[[], None],
) -> ExitCode:
    """Run one robot, from opening the session to the end of the run.

    Args:
        robot: its number.
        session: its identity on the network.
        conditions: the faults to inject.
        sessions: the run's private folder, with the host's command socket.
        again: whether it is the successor of a process that has died.
        on_connected: called when it has a session.

    Raises:
        UsageError: no router admits us.
        SessionLostError: see `open_transport`; or the world is silent, or has not recorded all.
    """
    keys, name = session.keys, robot_name(robot)
    incarnation = secrets.token_hex(4)
    life_number = secrets.randbits(LIFE_BITS) | 1  # never 0, which is of no robot
    alive = keys.alive(name, incarnation)
    victim = Victim(robot, sessions, conditions, again=again)
    hear, watch = heard(keys, name), tokens_of(keys, frozenset({beside(robot)}))
    with open_transport(session, hear=hear, answer=[], alive=alive, watch=watch) as transport:
        on_connected()
        shell = Shell(robot, session, transport, incarnation, conditions=conditions, victim=victim)
        mission = await shell.mission()
        if mission is None:
            raise SessionLostError("the world has told no mission")
        await shell.accept(mission)
        inputs = None if session.inputs is None else Path(session.inputs)
        head = Head(robot=robot, incarnation=incarnation, mission=mission, life=life_number, again=again)
        core = Robot(robot, mission, life=life_number, again=again)
        return await shell.run(core, open_journal(inputs, head, size_bytes_max=session.inputs_bytes_max))


class Shell:
    """The shell of one robot in one life of its process."""

    def __init__(
        self,
        robot: int,
        session: Session,
        transport: Transport,
        incarnation: str,
        *,
        conditions: Conditions,
        victim: Victim,
    ) -> None:
        self._robot, self._name = robot, robot_name(robot)
        self._keys = keys = session.keys
        self._odometry_key, self._logged_key = keys.odometry(self._name), keys.logged(self._name)
        self._transport = FaultyTransport(transport, conditions, self._keys, self._name, self._note)
        self._victim = victim
        self._incarnation = incarnation
        self._outbox = Outbox(incarnation, resend_s=resend_s(session.robots))
        self._now_s = 0.0
        self._phase = Phase.RUNNING
        self._looked_s = time.monotonic()
        self._world_silent_s = 0.0
        self._patience_s = WORLD_SILENCE_S
        self._lateness = Lateness()
        self._robots = session.robots
        """How many robots share the machine with this one."""
        self._turn_s = max(TURN_S, TURN_S_PER_ROBOT * session.robots)
        self._kept: list[Arrival] = []  # arrived, and not handled by the robot yet
        self._watched: frozenset[int] | None = None
        """Whose tokens are watched; None: those of all robots."""
        self._wanted: frozenset[int] | None = None
        """Whose tokens the core wanted to be watched last."""

    async def mission(self) -> Mission | None:
        """Ask the world until it answers; None if it does not."""
        # First of all: faults of the answer are recorded, but a log detects a new life by its first entry.
        self._note(RobotStarted(pid=os.getpid(), incarnation=self._incarnation))
        mission: Mission | None = None
        asking = Asking(self._robots, time.monotonic())
        while not asking.is_over(time.monotonic()):
            if asking.asks(time.monotonic()):
                self._transport.ask(self._keys.mission(), Ask())
            # Keep everything: tokens may arrive with the mission, and they are not sent again.
            for arrival in await self._transport.arrivals(asking.wait_s(time.monotonic())):
                match arrival:
                    case Heard(key, message=Mission() as told) if key == self._keys.mission():
                        mission = told
                    case Appeared(key) if self._keys.part(key, 1) == WORLD:
                        asking.world_came()
                        self._kept.append(arrival)
                    case _:
                        self._kept.append(arrival)
            if mission is not None:
                self._patience_s = WORLD_SILENCE_S + start_wall_s(self._robots)
                return mission
        return None

    async def accept(self, mission: Mission) -> None:
        """Refuse a mission whose law is not here; the timeline has the reason, which ends the run.

        A law that is here is watched, since it may never return.

        Raises:
            UsageError: the law is not here, or cannot be loaded.
        """
        try:
            find(mission.law)
        except UsageError as error:
            self._note(RobotFailed(reason=f"it refuses the mission: {error}"))
            await self._tell_last()
            raise
        watch_law(mission.law, self._note_now)

    async def run(self, robot: Robot, journal: Journal) -> ExitCode:
        """Give events to the robot and execute its commands, until the world closes the run."""
        self._watch(robot.watches)
        none = listed(frozenset({beside(self._robot)}))
        await self._obey(none.event, await self._decided(robot, none, journal))
        while self._phase is Phase.RUNNING:
            self._flush()
            self._lateness.turn(time.monotonic(), self._transport.busy_s, asked_s=self._turn_s)
            arrivals = [*self._kept, *await self._transport.arrivals(self._turn_s)]
            self._kept = []
            self._hear_world(arrivals)
            if self._phase is Phase.RUNNING:
                for given in self._events(arrivals):
                    await self._obey(given.event, await self._decided(robot, given, journal))
                self._watch(robot.watches)
            self._check_world()
        journal.end("the run is over")
        return await self._close()

    def _watch(self, wanted: frozenset[int] | None) -> None:
        """Watch the tokens that the core wants to be watched."""
        if wanted == self._wanted:
            return
        self._wanted = wanted
        robots = watched_by(self._robot, wanted)
        if robots != self._watched:
            self._watched = robots
            self._transport.watch(tokens_of(self._keys, robots))

    async def _decided(self, robot: Robot, given: Given, journal: Journal) -> list[Command]:
        """The robot's commands for an event. If the core fails, that is recorded before the process ends."""
        try:
            return decided(robot, given, self._now_s, journal)
        except Exception as error:
            self._note(failed(error))
            await self._tell_last()
            raise

    async def _obey(self, event: Event, commands: Sequence[Command]) -> None:
        notes = [command for command in commands if isinstance(command, Note)]
        faults = self._victim.faults_at(event, commands, self._now_s, self._transport.faults)
        if faults:
            await self._inject(faults, [note for note in notes if is_plan(note)])
            notes = [note for note in notes if not is_plan(note)]
        for note in notes:
            self._note(note.record)
        self._flush()
        for command in commands:
            self._do(command)

    async def _inject(self, faults: Sequence[ProcessFault], plans: Sequence[Note]) -> None:
        """Inject faults into this process (rule 4)."""
        for plan in plans:
            self._note(plan.record)
        for fault in faults:
            self._note(fault.as_record())
        until_s = time.monotonic() + FAULT_PATIENCE_S
        while len(self._outbox) and time.monotonic() < until_s:
            self._flush()
            arrivals = await self._transport.arrivals(self._turn_s)
            self._hear_world(arrivals)
            self._kept += [arrival for arrival in arrivals if not isinstance(arrival, Refused)]
        self._victim.inject(faults[-1])

    async def _close(self) -> ExitCode:
        """Record the sent counts; when all robots have, record the received ones; end when that is stored."""
        self._note(RobotSettled(sent=self._counted().sent))
        while self._phase is Phase.OVER:
            await self._turn()
            self._check_world()
        for part in in_parts(self._counted()):
            self._note(part)
        await self._tell_last()
        if left := len(self._outbox):
            raise SessionLostError(f"the world has not recorded the last {left} timeline entries")
        return ExitCode.OK

    async def _tell_last(self) -> None:
        """Wait until the entries are recorded, up to a limit."""
        until_s = time.monotonic() + CLOSING_PATIENCE_S
        while len(self._outbox) and time.monotonic() < until_s:
            await self._turn()

    async def _turn(self) -> None:
        self._flush()
        self._hear_world(await self._transport.arrivals(self._turn_s))

    def _hear_world(self, arrivals: Sequence[Arrival]) -> None:
        for arrival in arrivals:
            if isinstance(arrival, Heard):
                message = arrival.message
                if isinstance(message, Odometry) and arrival.key == self._odometry_key:
                    self._now_s = max(self._now_s, message.t_s)
                    self._phase = self._phase.later(message.phase)
                    self._world_silent_s, self._patience_s = 0.0, WORLD_SILENCE_S
                elif isinstance(message, Logged) and arrival.key == self._logged_key:
                    self._outbox.acknowledged(message)
            elif isinstance(arrival, Refused):
                self._note(MessageRefused(key=self._keys.behind_root(arrival.key), reason=arrival.reason))

    def _events(self, arrivals: Sequence[Arrival]) -> list[Given]:
        """The robot's events among the arrivals, in order, with only the newest odometry (rule 1)."""
        keys, name, now_s = self._keys, self._name, self._now_s
        events: list[Given] = []
        for arrival in arrivals:
            match arrival:
                case Heard():
                    path = keys.behind_root(arrival.key)
                    if (event := event_for(name, path, arrival, now_s)) is not None:
                        events.append(Given(event, path, arrival.number))
                case Appeared(key) | Vanished(key):
                    source = keys.part(key, 1)
                    robot = WORLD_NUMBER if source == WORLD else robot_number(source)
                    came_or_went = TokenCame if isinstance(arrival, Appeared) else TokenWent
                    if robot is not None and source != name:
                        token = came_or_went(robot, keys.part(key, 2))
                        events.append(Given(token, keys.behind_root(key), 0))
                case Listed():
                    events.append(listed(self._watched))
                case _:
                    pass  # a robot answers no queries; refused messages have been recorded
        return at_once(events)

    def _check_world(self) -> None:
        """Give up when the world has been silent for too long (rule 3).

        Raises:
            SessionLostError: it has.
        """
        now_s = time.monotonic()
        self._world_silent_s += min(now_s - self._looked_s, LOOK_S_MAX)
        self._looked_s = now_s
        if self._world_silent_s > self._patience_s:
            raise SessionLostError(f"the world has been silent for {self._patience_s:.0f} s")

    def _do(self, command: Command) -> None:
        match command:
            case Say(robot, said):
                self._transport.put(self._keys.view(self._name, robot_name(robot)), said)
            case Put(change):
                self._transport.put(self._keys.fence(self._name), change)
            case Tell(robot, state):
                self._transport.put(self._keys.link(self._name, robot_name(robot)), state)
            case Order(drive):
                late_s = round(self._lateness.now_s(time.monotonic()), 3)
                self._transport.put(self._keys.drive(self._name), replace(drive, late_s=late_s))
            case AskScan(revolutions):
                self._transport.ask(self._keys.scan(self._name), ScanQuery(revolutions=revolutions))
            case Note():
                pass  # already recorded (rule 2)

    def _note(self, record: Record) -> None:
        self._victim.note(record, self._now_s)
        self._outbox.add(record, t_s=self._transport.now_s, hlc=self._transport.timestamp())

    def _note_now(self, record: Record) -> None:
        self._note(record)
        self._flush()

    def _flush(self) -> None:
        # Most turns have nothing to tell, and need no look at the clock.
        while len(self._outbox) and (batch := self._outbox.batch(time.monotonic())) is not None:
            self._transport.put(self._keys.log(self._name), batch)

    def _counted(self) -> TrafficCounted:
        """Its message counts; the recorder's keys are counted separately."""
        apart = (self._keys.log(self._name), self._logged_key)
        traffic, lost = self._transport.traffic, self._outbox.lost_count
        return traffic.counted(self._keys.behind_root, apart=apart, unrecorded=lost)
