"""The rehearsal: a whole fleet and its world in one process, in virtual time, decided by one seed.

The cores are the ones that run live. Only the network is of its own kind (`lab.network`), and the
timeline is written without a recorder: no entry is ever lost.
"""

from collections import Counter
from collections.abc import Iterator
from random import Random

from agents.commands import Announce, AskScan, Order, Tell
from agents.commands import Command as RobotCommand
from agents.commands import Note as RobotNote
from agents.events import Event as RobotEvent
from agents.events import LinkHeard, MusterHeard, OdometryHeard, ScanHeard
from agents.robot import Robot
from lab.network import Network, NetworkFaults
from protocol.keys import WORLD, robot_name
from protocol.messages import Phase
from protocol.timeline import Entry, Record
from world.commands import Command as WorldCommand
from world.commands import Note, ServeScan, TellOdometry
from world.core import World
from world.events import EntryWritten, OrderHeard, ScanAsked, TokenCame, TokenWent
from world.events import Event as WorldEvent
from world.scenario import Scenario

ToRobot = tuple[int, RobotEvent]
Message = ToRobot | WorldEvent


class Rehearsal:
    """One rehearsed run, tick by tick."""

    def __init__(self, scenario: Scenario, seed: int, faults: NetworkFaults) -> None:
        robots = range(1, scenario.fleet.robots + 1)
        mission = scenario.mission()
        self.entries: list[tuple[str, Entry]] = []
        """The timeline: sources and their entries."""
        self.world = World(scenario, seed=seed, wall_s=0.0)
        chance = Random(f"{seed}/network")  # noqa: S311 - it has to be replayable, not secret
        self.network: Network[Message] = Network(faults, chance)
        self._robots = {robot: Robot(robot, mission) for robot in robots}
        self._now_s = dict.fromkeys(robots, 0.0)
        self._numbers: Counter[tuple[int, int]] = Counter()
        self._counts: Counter[str] = Counter()
        for robot in robots:
            self._tell_world(TokenCame(robot, "rehearsed"))

    def run(self) -> "Rehearsal":
        """Go on until the run is over."""
        for _ in self.ticks():
            pass
        return self

    def ticks(self) -> Iterator[float]:
        """Go on tick by tick; yields the time after each."""
        while self.world.phase is Phase.RUNNING:
            self._obey_all(self.world.look(wall_s=self.world.now_s))
            while (message := self.network.next_due(self.world.now_s)) is not None:
                self._deliver(message)
            self._obey_all(self.world.tick())
            yield self.world.now_s

    def kill(self, robot: int) -> None:
        """The robot's process is no more; its body stays."""
        del self._robots[robot]
        self._tell_world(TokenWent(robot, "rehearsed"))

    def _deliver(self, message: Message) -> None:
        if not isinstance(message, tuple):
            self._tell_world(message)
            return
        robot, event = message
        if robot not in self._robots:
            return
        if isinstance(event, OdometryHeard):
            if event.odometry.t_s < self._now_s[robot]:
                return  # the shell believes the newest only
            self._now_s[robot] = event.odometry.t_s
        for command in self._robots[robot].handle(event, self._now_s[robot]):
            self._obey_robot(robot, command)

    def _obey_robot(self, robot: int, command: RobotCommand) -> None:
        now_s = self.world.now_s
        match command:
            case Announce(muster):
                for other in self._robots:
                    if other != robot:
                        self.network.send((other, MusterHeard(robot, muster)), now_s)
            case Tell(other, state):
                self._numbers[robot, other] += 1
                told = LinkHeard(robot, self._numbers[robot, other], state)
                self.network.send((other, told), now_s)
            case Order(drive):
                self.network.send(OrderHeard(robot, drive), now_s)
            case AskScan():
                self.network.send(ScanAsked(robot), now_s)
            case RobotNote(record):
                self._write(robot_name(robot), self._now_s[robot], record)

    def _tell_world(self, event: WorldEvent) -> None:
        self._obey_all(self.world.handle(event, wall_s=self.world.now_s))

    def _obey_all(self, commands: list[WorldCommand]) -> None:
        now_s = self.world.now_s
        for command in commands:
            match command:
                case TellOdometry(robot, odometry):
                    self.network.send((robot, OdometryHeard(odometry)), now_s)
                case ServeScan(robot, scan):
                    self.network.send((robot, ScanHeard(scan)), now_s)
                case Note(t_s, record):
                    self._write(WORLD, t_s, record)

    def _write(self, source: str, t_s: float, record: Record) -> None:
        self._counts[source] += 1
        entry = Entry(n=self._counts[source], t_s=t_s, hlc="", record=record)
        self.entries.append((source, entry))
        self.world.handle(EntryWritten(source, entry), wall_s=self.world.now_s)
