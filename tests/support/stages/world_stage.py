"""A world on a stage: events in, messages and records out, without a network."""

import math
from itertools import pairwise

from msgspec.structs import replace

from protocol.fence import Bearing, Cause, Change, Fence, May, Raise, Turn
from protocol.frames import Point
from protocol.keys import WORLD, robot_name
from protocol.process.tokens import TokenCame
from protocol.timeline import Entry, Record, StepPlanned, StrandFormed, StrandJoined
from protocol.wire.messages import Drive, Odometry, Phase, Scan
from tests.support.logs.logs import HEADER
from tests.support.planned import planned as one_planned
from world.commands import Command, Note, ServeScan, TellOdometry
from world.core import World
from world.events import EntryRead, EntryWritten, Event, FencePut, OrderHeard, ScanAsked
from world.judge.ending import Ending
from world.record.resume import Past
from world.scenario.scenario import Scenario

EPOCH = 10_001
"""The number of the first epoch that robot 1 proposes."""


def life_of(robot: int) -> int:
    """The life of a robot on this stage."""
    return 100 + robot


def planned(target: Point, *, step: int = 1, epoch: int = EPOCH, reach_m: float = 0.0) -> StepPlanned:
    """A switching step planned by a leader, which promises no contact; only its target matters."""
    plan = replace(one_planned(step), epoch=epoch, length_m=0.0, target=target, reach_m=reach_m)
    return replace(plan, promised_clearance_m=0.0)


def formed(order: tuple[int, ...], places: tuple[Point, ...], *, epoch: int = EPOCH) -> StrandFormed:
    """A formation of robots that stand at these places, leader first; the legs between them are straight."""
    legs_m = [math.dist((a.x_m, a.y_m), (b.x_m, b.y_m)) for a, b in pairwise(places)]
    return StrandFormed(
        epoch=epoch,
        turn=1,
        order=order,
        lives=tuple(f"{life_of(robot):x}" for robot in order),
        places_m=tuple(sum(legs_m[rank:]) for rank in range(len(order))),
        laid=places[::-1],
        driven=(False,) * len(order),
        back_by_m=0.0,
        sensed=True,
    )


class Stage:
    """Plays the shell: writes the world's notes, keeps its messages. Wall time stands unless moved."""

    def __init__(self, scenario: Scenario, *, seed: int = 1, in_all: int = 0) -> None:
        self.wall_s = 0.0
        self.world = World(scenario, seed=seed, wall_s=self.wall_s, in_all=in_all)
        self.lines: list[tuple[str, Entry]] = []
        self.odometry: dict[int, list[Odometry]] = {robot: [] for robot in self.world.attendance.robots}
        self.scans: list[Scan] = []
        self.records: list[Record] = []
        """Everything that the world has recorded."""

    def resumed(self) -> "Stage":
        """A stage with a new world that resumes from this one's records."""
        again = Stage(self.world.scenario)
        again.wall_s, again.lines = self.wall_s, list(self.lines)
        past = Past(HEADER, 0, 0, self.lines)
        again.world = World(self.world.scenario, seed=1, wall_s=again.wall_s, past=past)
        for source, entry in self.lines:
            again.world.handle(EntryRead(source, entry), wall_s=again.wall_s)
        again._obey(again.world.resume(wall_s=again.wall_s))
        return again

    def at(self) -> tuple[bool, Phase, Ending | None]:
        """Whether the clock runs, the phase, and the end's reason. A method, since mypy never narrows one."""
        return self.world.started, self.world.phase, self.world.ending

    def handle(self, event: Event) -> list[Record]:
        """Hand in an event; returns the world's records of it."""
        return self._obey(self.world.handle(event, wall_s=self.wall_s))

    def look(self, *, after_wall_s: float = 0.0) -> list[Record]:
        """Let the world read the wall clock, this much later."""
        self.wall_s += after_wall_s
        return self._obey(self.world.look(wall_s=self.wall_s))

    def tick(self, ticks: int = 1, *, awake: bool = True) -> list[Record]:
        """Tick; after each tick all robots repeat their orders if they are awake."""
        records: list[Record] = []
        for _ in range(ticks):
            records += self._obey(self.world.tick())
            for robot in sorted(self.world.attendance.living) if awake else ():
                last = self.world.bodies.orders[robot - 1]
                if last is not None:
                    records += self.order(robot, last.target, number=last.number, step=last.step)
        return records

    def begin(self) -> None:
        """All robots connect, and the clock runs."""
        for robot in sorted(self.world.attendance.robots):
            self.handle(TokenCame(robot, "a"))
        self.look()
        self.form()
        self.odometry = {robot: told[-1:] for robot, told in self.odometry.items()}

    def put(self, robot: int, change: Change) -> list[Record]:
        """A robot, or the operator, puts a change of the fence; returns the world's records of it."""
        return self.handle(FencePut(robot, change))

    def form(self, leader: int = 1) -> None:
        """A robot coordinates a view that comes to ALL at once, and leads it; all are members."""
        epoch = self.fence.epoch.next(leader, life_of(leader))
        order = (leader, *sorted(self.world.attendance.robots - {leader}))
        members = len(order)
        self.put(leader, Raise(epoch=epoch, cause=Cause.START))
        self.write(leader, formed(order, tuple(map(self._place, order)), epoch=epoch.number))
        self.put(leader, Turn(fence=Fence(epoch=epoch, turn=1, may=May.ALL, robot=leader, members=members)))
        for rank, robot in enumerate(order):
            self.write(robot, StrandJoined(epoch=epoch.number, rank=rank, members=members))

    def _place(self, robot: int) -> Point:
        pose = self.world.bodies.pose(robot - 1)
        return Point(x_m=pose.x_m, y_m=pose.y_m)

    @property
    def fence(self) -> Fence:
        """What all bodies obey."""
        return self.world.arena.fence

    def bearing(self, robot: int) -> Bearing:
        """What an order of a robot bears that has heard the newest odometry."""
        return Bearing(epoch=self.fence.epoch, turn=self.fence.turn, life=life_of(robot))

    def order(
        self,
        robot: int,
        target: Point | None,
        *,
        number: int = 1,
        step: int = 0,
        basis_s: float | None = None,
        reach_m: float = 0.0,
        bearing: Bearing | None = None,
    ) -> list[Record]:
        """A robot gives its body an order; returns the world's records of it."""
        drive = Drive(
            number=number,
            basis_s=self.world.now_s if basis_s is None else basis_s,
            target=target,
            speed_mps=self.world.scenario.drive.speed_mps,
            bearing=self.bearing(robot) if bearing is None else bearing,
            step=step,
            reach_m=reach_m,
        )
        return self.handle(OrderHeard(robot, drive))

    def lead(self, robot: int, target: Point, *, number: int = 1, step: int = 1) -> None:
        """The leader drives a switching step, with the scan and the plan that make it valid."""
        self.handle(ScanAsked(robot, 1))
        self.write(robot, planned(target, step=step))
        self.order(robot, target, number=number, step=step)

    def write(self, robot: int, record: Record) -> None:
        """An entry of a robot reaches the recorder."""
        self._write(robot_name(robot), self.world.now_s, record)

    def record(self, record: Record) -> None:
        """The world's shell records something."""
        self._write(WORLD, self.world.now_s, record)

    def _obey(self, commands: list[Command]) -> list[Record]:
        records: list[Record] = []
        for command in commands:
            match command:
                case TellOdometry(robot, odometry):
                    self.odometry[robot].append(odometry)
                case ServeScan(_, scan):
                    self.scans.append(scan)
                case Note(t_s, record):
                    records.append(record)
                    self.records.append(record)
                    self._write(WORLD, t_s, record)
        return records

    def _write(self, source: str, t_s: float, record: Record) -> None:
        n = 1 + sum(name == source for name, _ in self.lines)
        entry = Entry(n=n, t_s=t_s, hlc="", record=record)
        self.lines.append((source, entry))
        self.world.handle(EntryWritten(source, entry), wall_s=self.wall_s)
        self.world.handle(EntryRead(source, entry), wall_s=self.wall_s)
