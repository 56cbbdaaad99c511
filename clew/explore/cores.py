"""The steps of single cores. They are pure, so each step of a core's content is computed once and remembered.

Most schedules differ in what one robot has heard: the steps of all others are then known already.
"""

import traceback
from collections.abc import Callable, Collection, Sequence
from typing import Any, NamedTuple, Protocol, assert_never, get_args

from msgspec import Struct

from agents.commands import AskScan, Order, Put, Say, Tell
from agents.commands import Command as RobotCommand
from agents.commands import Note as RobotNote
from agents.events import Event as RobotEvent
from agents.events import TokensWatched
from agents.navigation.grid import Lattice
from clew.explore.explorable import Breach
from clew.explore.judge import judge_world
from clew.explore.moments import WORLD, Letter
from clew.explore.store import Numbers, Snapshots
from clew.explore.trails import Trails
from clew.rehearsal.mail import event_for_robot, event_for_world
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import Record
from protocol.wire.messages import Drive, Message, ScanQuery
from protocol.wire.view import Formation
from world.bodies.arena import TICK_S
from world.commands import Command as WorldCommand
from world.commands import Note, ServeScan, TellOdometry
from world.core import World
from world.events import Event as WorldEvent


class Core(Protocol):
    """A robot's core."""

    def handle(self, event: RobotEvent, now_s: float) -> list[RobotCommand]:
        """Process an event."""
        ...


class Start(Struct, frozen=True):
    """The start of a robot's process, as a letter to it."""

    robot: int


class Tick(Struct, frozen=True):
    """Time goes on until the world tells odometry."""


class Restart(Struct, frozen=True):
    """The world is killed and started again."""


Thing = Any
"""What a letter can hold: a message, a token event, `Start`."""
MESSAGES = get_args(Message)
FIXED = (Lattice,)
"""Large objects in cores that nothing changes."""


class RobotStep(NamedTuple):
    """What a robot's core does with an event."""

    core: int
    sent: tuple[tuple[int, int], ...]
    """Receiver and content."""
    orders: tuple[Drive, ...]
    """Those to move."""
    pieces: tuple[tuple[int, Formation], ...]
    """Of formations: member, and what it is told."""
    notes: tuple[Record, ...]


class WorldStep(NamedTuple):
    """What the world does with an event."""

    world: int
    ticks: int
    fence: int
    places: tuple[Pose, ...] | None
    """Where all bodies stand, if the fence has changed."""
    sent: tuple[tuple[int, int], ...]
    ordered: tuple[tuple[int, Drive], ...]
    """Orders to move that bodies have accepted."""
    notes: tuple[Record, ...]


class Cores:
    """All contents that cores have had, and their steps."""

    def __init__(
        self, world: World, make: Callable[[int, int, bool], Core], constants: Sequence[object]
    ) -> None:
        self.things = Numbers[Thing]()
        self.fences = Numbers[Fence]()
        self._make = make
        self._robots = Trails[Core, tuple[Letter, float]](
            Snapshots(constants, self.things, MESSAGES, FIXED), self._let_robot_go_on
        )
        self._worlds = Trails[World, tuple[int, int]](
            Snapshots(constants, self.things, MESSAGES), self._let_world_go_on
        )
        self.first_world = self._worlds.add(world)
        self._robot_steps: dict[tuple[int, Letter, float], RobotStep] = {}
        self._world_steps: dict[tuple[int, int, int], WorldStep] = {}
        self.computed = 0
        """How many steps of single cores were computed."""

    def begin(self, robot: int, life: int, *, again: bool) -> int:
        """A new core of a robot."""
        return self._robots.add(self._make(robot, life, again))

    def world(self, number: int) -> World:
        """A copy of the world, to look at."""
        return self._worlds.load(number)

    def settle_robot(self, number: int) -> int:
        """The number of a core's content: two cores with one content have one number."""
        return self._robots.settle(number)

    def settle_world(self, number: int) -> int:
        """The number of a world's content."""
        return self._worlds.settle(number)

    def __len__(self) -> int:
        return len(self._robots) + len(self._worlds)

    def keep_only(self, robots: Collection[int], worlds: Collection[int]) -> None:
        """Forget all cores but these, and all steps."""
        self._robots.keep_only(robots)
        self._worlds.keep_only({*worlds, self.first_world})
        self._robot_steps, self._world_steps = {}, {}

    def _let_robot_go_on(self, core: Core, event: tuple[Letter, float]) -> list[RobotCommand]:
        letter, now_s = event
        return _handled(core, to_robot(self.things[letter.thing], letter), now_s)

    def _let_world_go_on(self, world: World, event: tuple[int, int]) -> list[WorldCommand]:
        thing, sender = event
        return act(world, self.things[thing], sender)

    def robot_step(self, core: int, letter: Letter, now_s: float) -> RobotStep:
        """The step of a robot's core that hears a letter."""
        key = (core, letter, now_s)
        step = self._robot_steps.get(key)
        if step is None:
            step = self._robot_steps[key] = self._compute_robot(core, letter, now_s)
        return step

    def _compute_robot(self, number: int, letter: Letter, now_s: float) -> RobotStep:
        core = self._robots.load(number)
        self.computed += 1
        sent: list[tuple[int, int]] = []
        orders: list[Drive] = []
        pieces: list[tuple[int, Formation]] = []
        notes: list[Record] = []
        for command in self._let_robot_go_on(core, (letter, now_s)):
            match command:
                case Say(receiver, said):
                    sent.append((receiver, self.things.add(said)))
                    if isinstance(said, Formation):
                        pieces.append((receiver, said))
                case Tell(receiver, state):
                    sent.append((receiver, self.things.add(state)))
                case Put(change):
                    sent.append((WORLD, self.things.add(change)))
                case Order(drive):
                    sent.append((WORLD, self.things.add(drive)))
                    if drive.target is not None:
                        orders.append(drive)
                case AskScan(revolutions):
                    sent.append((WORLD, self.things.add(ScanQuery(revolutions=revolutions))))
                case RobotNote(record):
                    notes.append(record)
                case _:
                    assert_never(command)
        after = self._robots.follow(number, (letter, now_s), core)
        return RobotStep(after, tuple(sent), tuple(orders), tuple(pieces), tuple(notes))

    def world_step(self, number: int, thing: int, sender: int) -> WorldStep:
        """The step of the world that hears a letter, or in which time passes. Raises `Breach`."""
        key = (number, thing, sender)
        step = self._world_steps.get(key)
        if step is None:
            step = self._world_steps[key] = self._compute_world(number, thing, sender)
        return step

    def _compute_world(self, number: int, thing: int, sender: int) -> WorldStep:
        world = self._worlds.load(number)
        self.computed += 1
        before = world.arena.fence
        commands = self._let_world_go_on(world, (thing, sender))
        notes = [command.record for command in commands if isinstance(command, Note)]
        ordered = judge_world(world, before, notes, sender)
        sent: list[tuple[int, int]] = []
        for command in commands:
            match command:
                case TellOdometry(robot, odometry):
                    sent.append((robot, self.things.add(odometry)))
                case ServeScan(robot, scan):
                    sent.append((robot, self.things.add(scan)))
                case Note():
                    pass  # judged above
                case _:
                    assert_never(command)
        fence, ticks = world.arena.fence, round(world.now_s / TICK_S)
        poses = tuple(map(world.bodies.pose, range(len(world.bodies.place_m))))
        return WorldStep(
            world=self._worlds.follow(number, (thing, sender), world),
            ticks=ticks,
            fence=self.fences.add(fence),
            places=None if fence == before else poses,
            sent=tuple(sent),
            ordered=tuple(ordered),
            notes=tuple(notes),
        )


def _handled(core: Core, event: RobotEvent, now_s: float) -> list[RobotCommand]:
    try:
        return core.handle(event, now_s)
    except Exception as error:  # it would end the process
        where = traceback.extract_tb(error.__traceback__)[-1]
        raise Breach("P6", f"{error!r} at {where.filename}:{where.lineno}") from error


def to_robot(thing: Thing, letter: Letter) -> RobotEvent:
    """The event that a letter is for a robot's core."""
    if isinstance(thing, TokenCame | TokenWent | TokensWatched):
        return thing
    event = event_for_robot(thing, letter.sender, letter.number)
    assert event is not None, f"no message for a robot: {thing}"
    return event


def act(world: World, thing: Thing, sender: int) -> list[WorldCommand]:
    """Let the world process what has arrived, or let time pass."""
    match thing:
        case Restart():
            return world.restart(wall_s=world.now_s)
        case Tick():
            return _pass_time(world)
        case TokenCame() | TokenWent():
            event: WorldEvent | None = thing
        case _:
            event = event_for_world(thing, sender)
    assert event is not None, f"no message for the world: {thing}"
    return world.handle(event, wall_s=world.now_s)


def _pass_time(world: World) -> list[WorldCommand]:
    commands = world.look(wall_s=world.now_s)
    while not any(isinstance(command, TellOdometry) for command in commands):
        commands += world.tick()
        commands += world.look(wall_s=world.now_s)
    return commands
