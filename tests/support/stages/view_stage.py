"""Up to five real robots in the real world; the test decides what becomes of each message. Not a test file.

Rule 1: every message is a letter. By default it arrives at once, in the order of sending; then time passes
        until the world tells odometry. This is how a rehearsal without faults goes.
Rule 2: a test may keep letters back, lose them, or post them again: `hold`, `lose`, `post`.
Rule 3: after every step the judge of the exploration asks for F1 to F4, S1 and S2 (`clew.explore.judge`).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar

from agents.commands import AskScan, Command, Note, Order, Put, Say, Tell
from agents.events import TokensWatched
from agents.robot import Robot
from clew.explore.cores import Tick, act, to_robot
from clew.explore.judge import judge_member, judge_order, judge_piece, judge_places, judge_world
from clew.explore.moments import WORLD, Letter
from clew.explore.setting import QUEUE, Setting
from protocol.fence import Fence, May, Raise
from protocol.frames import Pose
from protocol.keys import robot_name
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import Entry, Record, StrandFormed
from protocol.wire.messages import Odometry, ScanQuery
from protocol.wire.view import Formation
from tests.support.logs.logs import HEADER
from world.commands import Command as WorldCommand
from world.commands import Note as WorldNote
from world.commands import ServeScan, TellOdometry
from world.core import World
from world.record.resume import Past
from world.scenario.scenario import Scenario

RUN_S_MAX = 60.0
Places = tuple[tuple[float, float, float], ...]
Thing = Any
"""What a letter can hold: a message, or a token event."""
T = TypeVar("T")


class Post(NamedTuple):
    """A message on its way."""

    sender: int
    receiver: int
    number: int
    thing: Thing

    def __str__(self) -> str:
        return f"{_name(self.sender)} -> {_name(self.receiver)}: {self.thing}"


Rule = Callable[[Post], bool]


def of(
    kind: type | tuple[type, ...], *, sender: int | None = None, receiver: int | None = None, **fields: object
) -> Rule:
    """The rule for messages of a kind, a sender, a receiver, and with these values of fields."""

    def matches(post: Post) -> bool:
        return (
            isinstance(post.thing, kind)
            and sender in (None, post.sender)
            and receiver in (None, post.receiver)
            and all(getattr(post.thing, name) == value for name, value in fields.items())
        )

    return matches


@dataclass(slots=True)
class Process:
    """One life of one robot."""

    robot: Robot
    life: int
    now_s: float = 0.0
    told: Odometry | None = None
    """Its newest odometry, by fence and number."""
    sent: int = 0


@dataclass(slots=True)
class ViewStage:
    """A fleet, its world, and all letters."""

    scenario: Scenario
    world: World = field(init=False)
    processes: dict[int, Process] = field(default_factory=dict)
    mail: list[Post] = field(default_factory=list)
    held: list[Post] = field(default_factory=list)
    posted: list[Post] = field(default_factory=list)
    """All that was ever sent, in order."""
    records: list[tuple[int, float, Record]] = field(default_factory=list)
    lives: dict[int, int] = field(default_factory=dict)
    _holds: list[Rule] = field(default_factory=list)
    _losses: list[Rule] = field(default_factory=list)
    _formed: StrandFormed | None = None
    _worlds: int = 1

    def __post_init__(self) -> None:
        self.world = World(self.scenario, seed=1, wall_s=0.0)

    @classmethod
    def begun(cls, places: Places = QUEUE, scenario: Scenario | None = None) -> "ViewStage":
        """A stage on which all robots have just been started, in an open field or a scenario."""
        field_ = Setting(name="stage", about="a conversation", places=places).scenario()
        stage = cls(field_ if scenario is None else scenario)
        for robot in stage.robots:
            stage.start(robot)
        return stage

    @classmethod
    def driving(cls, places: Places = QUEUE, scenario: Scenario | None = None) -> "ViewStage":
        """A stage on which a strand has formed, and drives."""
        stage = cls.begun(places, scenario)
        stage.run(lambda: stage.fence.may is May.ALL)
        return stage

    # --- what is so ---------------------------------------------------------------------------------

    @property
    def robots(self) -> range:
        """All robots of the fleet."""
        return range(1, self.scenario.fleet.robots + 1)

    @property
    def fence(self) -> Fence:
        """What all bodies obey."""
        return self.world.arena.fence

    @property
    def now_s(self) -> float:
        """Simulated time."""
        return self.world.now_s

    @property
    def formed(self) -> StrandFormed | None:
        """The formation of the epoch in force."""
        return self._formed

    def place(self, robot: int) -> tuple[float, float]:
        """Where a body is."""
        pose = self.world.bodies.pose(robot - 1)
        return pose.x_m, pose.y_m

    def moving(self) -> set[int]:
        """The robots whose bodies move."""
        return {robot for robot in self.robots if self.world.bodies.is_moving(robot - 1)}

    def apart_m(self, one: int, other: int) -> float:
        """The distance between two bodies."""
        return math.dist(self.place(one), self.place(other))

    def records_of(self, kind: type[T], robot: int | None = None, *, since_s: float = 0.0) -> list[T]:
        """What was recorded of a kind, by a robot or by anybody; robot 0 is the world."""
        return [
            record
            for source, t_s, record in self.records
            if isinstance(record, kind) and robot in (None, source) and t_s >= since_s
        ]

    def sent(self, rule: Rule) -> list[Post]:
        """All letters of a rule that were ever sent."""
        return [post for post in self.posted if rule(post)]

    # --- what the test does -------------------------------------------------------------------------

    def hold(self, rule: Rule) -> None:
        """Keep letters of this rule back, until `release`."""
        self._holds.append(rule)

    def lose(self, rule: Rule) -> None:
        """Lose letters of this rule from now on, until `heal`."""
        self._losses.append(rule)

    def heal(self) -> None:
        """Nothing is lost any more."""
        self._losses.clear()

    def release(self) -> list[Post]:
        """Let everything that was kept back go, behind what is on its way; returns it."""
        self._holds.clear()
        held, self.held = self.held, []
        self.mail += held
        return held

    def forget(self) -> list[Post]:
        """Drop everything that was kept back, and keep nothing back any more; returns it."""
        self._holds.clear()
        held, self.held = self.held, []
        return held

    def post(self, *letters: Post) -> None:
        """Put letters on their way: old ones once more, or made ones."""
        self.mail += letters

    def push(self, robot: int, x_m: float, y_m: float) -> None:
        """Somebody puts a body, which stands, elsewhere."""
        bodies, body = self.world.bodies, robot - 1
        pose = Pose(x_m=x_m, y_m=y_m, heading_rad=0.0)
        ordered, finished = bodies[body].ordered, bodies[body].finished_number
        bodies.resume(body, pose, ordered=ordered, finished=finished, now_s=self.now_s)

    def raised_by(self, robot: int) -> None:
        """Go on until this robot's view has begun; all others' raises to the same generation are lost."""
        generation = self.fence.epoch.generation + 1

        def is_anothers(post: Post) -> bool:
            is_raise = isinstance(post.thing, Raise) and post.sender != robot
            return is_raise and bool(post.thing.epoch.generation == generation)

        self.lose(is_anothers)
        self.run(lambda: self.fence.epoch.robot == robot)

    def start(self, robot: int) -> None:
        """A robot's process starts; it and all others see each other's tokens."""
        life = self.lives[robot] = self.lives.get(robot, 1000 * robot) + 1
        core = Robot(robot, self.scenario.mission(), life=life, again=life > 1000 * robot + 1)
        others = [other for other in self.processes if other != robot]
        self.processes[robot] = Process(core, life)
        self._to_world(TokenCame(robot, str(life)), WORLD)
        for other in others:
            self._to_robot(Post(WORLD, other, 0, TokenCame(robot, str(life))))
        for other, incarnation in [(WORLD, self._worlds), *((other, self.lives[other]) for other in others)]:
            self._to_robot(Post(WORLD, robot, 0, TokenCame(other, str(incarnation))))
        self._to_robot(Post(WORLD, robot, 0, TokensWatched(None)))

    def kill(self, robot: int) -> None:
        """A robot's process dies; all others see its token go."""
        life = self.processes.pop(robot).life
        self._to_world(TokenWent(robot, str(life)), WORLD)
        for other in self.processes:
            self._to_robot(Post(WORLD, other, 0, TokenWent(robot, str(life))))

    def replace(self, robot: int) -> None:
        """A robot's process dies, and another is started at once."""
        self.kill(robot)
        self.start(robot)

    def resume_world(self) -> None:
        """The world is killed, what was on its way to it is lost, and it goes on from its timeline."""
        counts: dict[str, int] = {}
        lines: list[tuple[str, Entry]] = []
        for source, t_s, record in self.records:
            name = _name(source)
            counts[name] = counts.get(name, 0) + 1
            lines.append((name, Entry(n=counts[name], t_s=t_s, hlc="", record=record)))
        past = Past(HEADER, 0, 0, lines)
        self.mail = [post for post in self.mail if post.receiver != WORLD]
        before = self.fence
        self.world = World(self.scenario, seed=1, wall_s=self.now_s, past=past)
        self._worlds += 1
        self._obey_world(self.world.resume(wall_s=self.now_s), before, WORLD)
        for robot, process in self.processes.items():
            self._to_world(TokenCame(robot, str(process.life)), WORLD)

    def run(self, until: Callable[[], bool], *, s_max: float = RUN_S_MAX) -> None:
        """Go on until something is so."""
        end_s = self.now_s + s_max
        while not until():
            assert self.now_s < end_s, f"still not so after {s_max} s; {self.fence}"
            self.step()

    def pass_s(self, seconds: float) -> None:
        """Go on for some time."""
        end_s = self.now_s + seconds
        self.run(lambda: self.now_s >= end_s - 1e-6, s_max=math.inf)

    def step(self) -> None:
        """The next letter arrives, or time passes."""
        if not self.mail:
            self._to_world(Tick(), WORLD)
            return
        post = self.mail.pop(0)
        if any(rule(post) for rule in self._losses):
            return
        if any(rule(post) for rule in self._holds):
            self.held.append(post)
        else:
            self.deliver(post)

    def deliver(self, post: Post) -> None:
        """A letter arrives now."""
        if post.receiver == WORLD:
            self._to_world(post.thing, post.sender)
        else:
            self._to_robot(post)

    # --- cores --------------------------------------------------------------------------------------

    def _to_world(self, thing: Thing, sender: int) -> None:
        before = self.fence
        self._obey_world(act(self.world, thing, sender), before, sender)

    def _obey_world(self, commands: Sequence[WorldCommand], before: Fence, put_by: int) -> None:
        notes = [command.record for command in commands if isinstance(command, WorldNote)]
        self.records += [(WORLD, self.now_s, record) for record in notes]
        ordered = judge_world(self.world, before, notes, put_by)
        if self.fence.epoch != before.epoch:
            self._formed = None
        if self.fence != before and self.fence.may is May.ALL:
            poses = [self.world.bodies.pose(robot - 1) for robot in self.robots]
            judge_places(self.fence, self._formed, poses, self.world.scenario.law.mu0_m)
        for robot, drive in ordered:
            if self.fence.may is May.ALL:
                judge_member(robot, drive, self._formed)
        for command in commands:
            match command:
                case TellOdometry(robot, odometry):
                    self._send(Post(WORLD, robot, 0, odometry))
                case ServeScan(robot, scan):
                    self._send(Post(WORLD, robot, 0, scan))
                case WorldNote():
                    pass

    def _to_robot(self, post: Post) -> None:
        process = self.processes.get(post.receiver)
        if process is None:
            return
        if isinstance(post.thing, Odometry):
            process.now_s = max(process.now_s, post.thing.t_s)
            if process.told is None or _age(post.thing) > _age(process.told):
                process.told = post.thing
        letter = Letter(post.sender, post.receiver, post.number, 0)
        for command in process.robot.handle(to_robot(post.thing, letter), process.now_s):
            self._obey(post.receiver, process, command)

    def _obey(self, robot: int, process: Process, command: Command) -> None:
        match command:
            case Say(receiver, said):
                if isinstance(said, Formation) and said.epoch == self.fence.epoch:
                    judge_piece(said, receiver, self._formed)
                self._send_of(robot, process, receiver, said)
            case Tell(receiver, state):
                self._send_of(robot, process, receiver, state)
            case Put(change):
                self._send_of(robot, process, WORLD, change)
            case Order(drive):
                if drive.target is not None:
                    told = None if process.told is None else process.told.fence
                    judge_order(robot, process.life, drive, told)
                self._send_of(robot, process, WORLD, drive)
            case AskScan(revolutions):
                self._send_of(robot, process, WORLD, ScanQuery(revolutions=revolutions))
            case Note(record):
                self.records.append((robot, process.now_s, record))
                if isinstance(record, StrandFormed) and record.epoch == self.fence.epoch.number:
                    assert self._formed is None, "F4: a second formation in one epoch"
                    self._formed = record

    def _send_of(self, robot: int, process: Process, receiver: int, thing: Thing) -> None:
        process.sent += 1
        self._send(Post(robot, receiver, process.sent, thing))

    def _send(self, post: Post) -> None:
        self.mail.append(post)
        self.posted.append(post)


def _age(odometry: Odometry) -> tuple[tuple[int, int, int], int]:
    return odometry.fence.key, odometry.n


def _name(process: int) -> str:
    return robot_name(process) if process else "world"


def in_turn(coordinator: int, robot: int, places: Places) -> ViewStage:
    """A stage on which the coordinator has given a robot the turn, and it drives."""
    stage = ViewStage.begun(places)
    stage.raised_by(coordinator)
    stage.run(lambda: stage.fence.may is May.ONE and stage.fence.robot == robot and stage.moving() == {robot})
    return stage
