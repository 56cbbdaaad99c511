"""A world on a stage: events in, messages and records out, without a network."""

from protocol.frames import Point
from protocol.keys import WORLD, robot_name
from protocol.mission import Law
from protocol.timeline import Entry, Record, StepPlanned, StrandFormed
from protocol.wire.messages import Drive, Odometry, Phase, Scan
from tests.support.logs.logs import HEADER
from world.commands import Command, Note, ServeScan, TellOdometry
from world.core import World
from world.events import EntryWritten, Event, OrderHeard, TokenCame
from world.judge.ending import Ending
from world.record.resume import Past
from world.scenario.scenario import Scenario


def planned(target: Point, *, step: int = 1, epoch: int = 1, reach_m: float = 0.0) -> StepPlanned:
    """A switching step planned by a leader; only its target matters."""
    return StepPlanned(
        step=step,
        epoch=epoch,
        law=Law.CERTIFIED,
        x_m=0.0,
        y_m=0.0,
        obstacles=(),
        gaps=(),
        gap=None,
        heading_rad=0.0,
        length_m=0.0,
        target=target,
        reach_m=reach_m,
        promised_clearance_m=None,
        cost_to_go_m=None,
    )


class Stage:
    """Plays the shell: writes the world's notes, keeps its messages. Wall time stands unless moved."""

    def __init__(self, scenario: Scenario, *, seed: int = 1) -> None:
        self.wall_s = 0.0
        self.world = World(scenario, seed=seed, wall_s=self.wall_s)
        self.lines: list[tuple[str, Entry]] = []
        self.odometry: dict[int, list[Odometry]] = {robot: [] for robot in self.world.attendance.robots}
        self.scans: list[Scan] = []
        self.records: list[Record] = []
        """Everything that the world has recorded."""

    def resumed(self) -> "Stage":
        """A stage with a new world that resumes from this one's records."""
        again = Stage(self.world.scenario)
        again.wall_s, again.lines = self.wall_s, list(self.lines)
        past = Past(HEADER, self.lines, whole_bytes=0, torn_bytes=0)
        again.world = World(self.world.scenario, seed=1, wall_s=again.wall_s, past=past)
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

    def order(
        self,
        robot: int,
        target: Point | None,
        *,
        number: int = 1,
        step: int = 0,
        basis_s: float | None = None,
        reach_m: float = 0.0,
        epoch: int = 1,
    ) -> list[Record]:
        """A robot gives its body an order; returns the world's records of it."""
        drive = Drive(
            number=number,
            basis_s=self.world.now_s if basis_s is None else basis_s,
            target=target,
            speed_mps=self.world.scenario.drive.speed_mps,
            epoch=epoch,
            step=step,
            reach_m=reach_m,
        )
        return self.handle(OrderHeard(robot, drive))

    def lead(self, robot: int, target: Point, *, number: int = 1, step: int = 1) -> None:
        """A robot drives a switching step, with the strand and the plan that make it valid."""
        order = (robot, *sorted(self.world.attendance.robots - {robot}))
        self.write(robot, StrandFormed(epoch=1, sensed=True, order=order, path_length_m=0.0))
        self.write(robot, planned(target, step=step))
        self.order(robot, target, number=number, step=step)

    def write(self, robot: int, record: Record) -> None:
        """An entry of a robot reaches the recorder."""
        self._write(robot_name(robot), self.world.now_s, record)

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
