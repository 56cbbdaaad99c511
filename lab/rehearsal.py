"""The rehearsal: a whole fleet and its world in one process, in virtual time, decided by one seed.

Rule 1: the cores are the ones that run live. Only the network is of its own kind (`lab.network`), and the
        timeline needs no outbox: no entry is ever lost.
Rule 2: whatever a robot does on a live run beside its core (the newest odometry, the phases, the books), it
        does here as well: docs/run.md.
Rule 3: nothing depends on the wall clock, on process ids, or on the order of a set.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from random import Random

from agents.commands import Announce, AskScan, Order, Tell
from agents.commands import Command as RobotCommand
from agents.commands import Note as RobotNote
from agents.events import Event as RobotEvent
from agents.events import LinkHeard, MusterHeard, OdometryHeard, ScanHeard
from agents.robot import Robot
from lab.network import Network, NetworkFaults
from protocol.exit_codes import ExitCode
from protocol.keys import WORLD, Keys, robot_name
from protocol.messages import Odometry, Phase
from protocol.timeline import Entry, Record, RobotSettled, RobotStarted, TrafficCounted
from protocol.traffic import Traffic
from world.books import Account
from world.commands import Command as WorldCommand
from world.commands import Note, ServeScan, TellOdometry
from world.core import World
from world.events import EntryWritten, OrderHeard, ScanAsked, StopAsked, TokenCame, TokenWent
from world.events import Event as WorldEvent
from world.scenario import Scenario

NO_PROCESS = 0  # the process id of a robot that has none of its own
UNCOUNTED = ""  # the key of what is not in the books: queries and their answers
NTP64_PER_S = 2**32  # what Zenoh's time stamps count in

_PHASES = list(Phase)
_KEYS = Keys("clew", "rehearsed")  # the books leave out what all keys of a run start with


@dataclass(frozen=True, slots=True)
class ToWorld:
    """A message on its way to the world, its key and its number on that."""

    event: WorldEvent
    key: str
    number: int


@dataclass(frozen=True, slots=True)
class ToRobot:
    """A message on its way to a robot."""

    robot: int
    event: RobotEvent
    key: str
    number: int


@dataclass(slots=True)
class _Actor:
    """A robot and what the shell of a live one remembers."""

    core: Robot
    now_s: float = 0.0
    phase: Phase = Phase.RUNNING
    traffic: Traffic = field(default_factory=Traffic)

    def hear_world(self, odometry: Odometry) -> bool:
        """Believe the newest odometry only; whether this is it."""
        newest = odometry.t_s >= self.now_s
        self.now_s = max(self.now_s, odometry.t_s)
        self.phase = max(self.phase, odometry.phase, key=_PHASES.index)
        return newest


class Rehearsal:
    """One rehearsed run, tick by tick."""

    def __init__(self, scenario: Scenario, seed: int, faults: NetworkFaults) -> None:
        robots = range(1, scenario.fleet.robots + 1)
        mission = scenario.mission()
        self.entries: list[tuple[str, Entry]] = []
        """The timeline: sources and their entries."""
        self.world = World(scenario, seed=seed, wall_s=0.0)
        chance = Random(f"{seed}/network")  # noqa: S311 - it has to be replayable, not secret
        self.network: Network[ToWorld | ToRobot] = Network(faults, chance)
        self._actors = {robot: _Actor(Robot(robot, mission)) for robot in robots}
        self._traffic = Traffic()
        self._counts: Counter[str] = Counter()
        self._stamps: Counter[str] = Counter()
        for robot in robots:
            self._write(robot_name(robot), 0.0, RobotStarted(pid=NO_PROCESS))
            self._tell_world(TokenCame(robot, "rehearsed"))

    @property
    def account(self) -> Account:
        """What the world itself sent and received."""
        ours = self._traffic
        return Account(sent=ours.sent, received=ours.received, newest=ours.newest)

    def run(self) -> "Rehearsal":
        """Go on until the run has been judged."""
        for _ in self.ticks():
            pass
        return self

    def ticks(self) -> Iterator[float]:
        """Go on tick by tick until the run has been judged; yields the time after each."""
        while self.world.judgement is None:
            self._obey_all(self.world.look(wall_s=self.world.now_s))
            while (message := self.network.next_due(self.world.now_s)) is not None:
                self._deliver(message)
            self._obey_all(self.world.tick())
            yield self.world.now_s

    def kill(self, robot: int) -> None:
        """The robot's process is no more; its body stays."""
        del self._actors[robot]
        self._tell_world(TokenWent(robot, "rehearsed"))

    def stop(self, exit_code: ExitCode) -> None:
        """The user wants the run to end."""
        self._tell_world(StopAsked(exit_code))

    def _deliver(self, message: ToWorld | ToRobot) -> None:
        if isinstance(message, ToWorld):
            _receive(self._traffic, message)
            self._tell_world(message.event)
        elif (actor := self._actors.get(message.robot)) is not None:
            _receive(actor.traffic, message)
            self._tell_robot(message.robot, actor, message.event)

    def _tell_robot(self, robot: int, actor: _Actor, event: RobotEvent) -> None:
        before = actor.phase
        if isinstance(event, OdometryHeard) and not actor.hear_world(event.odometry):
            return
        if actor.phase is Phase.RUNNING:
            for command in actor.core.handle(event, actor.now_s):
                self._obey_robot(robot, actor, command)
        elif actor.phase is not before:
            self._close(robot, actor, before)

    def _close(self, robot: int, actor: _Actor, before: Phase) -> None:
        """Say what was sent; when all have, say what was received, and go."""
        traffic = actor.traffic
        if before is Phase.RUNNING:
            self._write(robot_name(robot), actor.now_s, RobotSettled(sent=dict(traffic.sent)))
        if actor.phase is Phase.CLOSING:
            counted = TrafficCounted(
                sent=dict(traffic.sent),
                received=dict(traffic.received),
                newest=traffic.newest,
                refused=0,
                overflowed=0,
                unrecorded=0,
            )
            self._write(robot_name(robot), actor.now_s, counted)
            self.kill(robot)

    def _obey_robot(self, robot: int, actor: _Actor, command: RobotCommand) -> None:
        now_s = self.world.now_s
        match command:
            case Announce(muster):
                key = _muster_key(robot)
                number = actor.traffic.send(key)
                for other in self._actors:
                    if other != robot:
                        self.network.send(ToRobot(other, MusterHeard(robot, muster), key, number), now_s)
            case Tell(other, state):
                key = _link_key(robot, other)
                number = actor.traffic.send(key)
                self.network.send(ToRobot(other, LinkHeard(robot, number, state), key, number), now_s)
            case Order(drive):
                key = _drive_key(robot)
                self.network.send(ToWorld(OrderHeard(robot, drive), key, actor.traffic.send(key)), now_s)
            case AskScan(revolutions):
                self.network.send(ToWorld(ScanAsked(robot, revolutions), UNCOUNTED, 0), now_s)
            case RobotNote(record):
                self._write(robot_name(robot), actor.now_s, record)

    def _tell_world(self, event: WorldEvent) -> None:
        self._obey_all(self.world.handle(event, wall_s=self.world.now_s))

    def _obey_all(self, commands: list[WorldCommand]) -> None:
        now_s = self.world.now_s
        for command in commands:
            match command:
                case TellOdometry(robot, odometry):
                    key = _odometry_key(robot)
                    number = self._traffic.send(key)
                    self.network.send(ToRobot(robot, OdometryHeard(odometry), key, number), now_s)
                case ServeScan(robot, scan):
                    self.network.send(ToRobot(robot, ScanHeard(scan), UNCOUNTED, 0), now_s)
                case Note(t_s, record):
                    self._write(WORLD, t_s, record)

    def _write(self, source: str, t_s: float, record: Record) -> None:
        self._counts[source] += 1
        # As Zenoh's clock: no two time stamps of one source are the same.
        self._stamps[source] = max(self._stamps[source] + 1, int(t_s * NTP64_PER_S))
        hlc = f"{self._stamps[source]}/{source}"
        entry = Entry(n=self._counts[source], t_s=t_s, hlc=hlc, record=record)
        self.entries.append((source, entry))
        self.world.handle(EntryWritten(source, entry), wall_s=self.world.now_s)


def _receive(traffic: Traffic, message: ToWorld | ToRobot) -> None:
    if message.key != UNCOUNTED:
        traffic.receive(message.key, message.number)


@cache
def _muster_key(robot: int) -> str:
    return _KEYS.behind_root(_KEYS.muster(robot_name(robot)))


@cache
def _link_key(robot: int, other: int) -> str:
    return _KEYS.behind_root(_KEYS.link(robot_name(robot), robot_name(other)))


@cache
def _drive_key(robot: int) -> str:
    return _KEYS.behind_root(_KEYS.drive(robot_name(robot)))


@cache
def _odometry_key(robot: int) -> str:
    return _KEYS.behind_root(_KEYS.odometry(robot_name(robot)))
