"""Members of a strand with bodies, sensors, a fence and a bad network; no coordinator. Not a test file.

The robots' parts (`agents.strand.member`) are the real ones. The stage does what a view does: it raises the
fence, takes the places at which the bodies stand, and gives each robot its formation.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from random import Random
from typing import TypeVar

import numpy as np
from msgspec.structs import replace

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import AskScan, Command, Note, Tell
from agents.events import LinkHeard
from agents.liveness.reason import Turnabout
from agents.strand.member import Member
from agents.strand.memory import Memory
from protocol.arrays import scan_bearings_rad
from protocol.fence import Cause, Epoch, Fence, obeys
from protocol.frames import Pose
from protocol.mission import Mission
from protocol.path import Path
from protocol.timeline import Record
from protocol.wire.messages import AheadState, Drive, Odometry, Phase, Scan
from protocol.wire.view import Counters, Formation
from tests.support.stages.strand_stage import fence_all, formation, life_of, queue_path
from world.geometry.clearance import clearance
from world.geometry.rays import cast
from world.geometry.shapes import Shape, ground_of

PERIOD_S = 0.1  # of odometry
ON_THE_SPOT_M = 1e-9

T = TypeVar("T")


@dataclass(slots=True)
class Body:
    """Drives straight to the target of the newest order that its fence lets it obey."""

    robot: int
    x_m: float
    y_m: float
    fence: Fence = Fence()  # noqa: RUF009 - it is frozen
    order: Drive | None = None
    ordered: int = 0
    finished: int = 0
    told: int = 0
    stood_s: float = 0.0  # of this body; a world tells it of all bodies

    def take(self, drive: Drive) -> None:
        if drive.number <= self.ordered:
            return
        if drive.target is None:
            self.order, self.ordered, self.finished = None, drive.number, drive.number
        elif obeys(self.fence, self.robot, drive.bearing):
            self.order, self.ordered = drive, drive.number

    def fenced(self, fence: Fence) -> None:
        self.fence, self.order = fence, None

    def live(self, for_s: float) -> None:
        if self.order is None or self.order.target is None:
            self.stood_s += for_s
            return
        self.stood_s = 0.0
        off_x, off_y = self.order.target.x_m - self.x_m, self.order.target.y_m - self.y_m
        left_m, way_m = math.hypot(off_x, off_y), self.order.speed_mps * for_s
        if left_m <= way_m + ON_THE_SPOT_M:
            self.x_m, self.y_m = self.order.target.x_m, self.order.target.y_m
            self.finished, self.order = self.order.number, None
        else:
            self.x_m += off_x * way_m / left_m
            self.y_m += off_y * way_m / left_m

    @property
    def pose(self) -> Pose:
        return Pose(x_m=self.x_m, y_m=self.y_m, heading_rad=0.0)

    def odometry(self, t_s: float) -> Odometry:
        self.told += 1
        return Odometry(
            n=self.told,
            t_s=t_s,
            pose=self.pose,
            moving=self.order is not None,
            finished=self.finished,
            ordered=self.ordered,
            fence=self.fence,
            stood_s=self.stood_s,
            phase=Phase.RUNNING,
        )


@dataclass(slots=True)
class Part:
    """What one robot keeps from strand to strand."""

    driver: Driver
    senses: Senses
    memory: Memory


@dataclass(slots=True)
class MemberStage:
    """The robots, their bodies, and the messages in transit."""

    mission: Mission
    places: Mapping[int, Pose]
    order: tuple[int, ...]
    shapes: Sequence[Shape] = ()
    loss: float = 0.0
    """Share of the link messages that are lost."""
    odd: float = 0.0
    """Share of the others that come late, or come twice."""
    seed: int = 0
    counters: Counters = Counters()  # noqa: RUF009 - it is frozen
    now_s: float = 0.0
    told: list[tuple[int, Record]] = field(default_factory=list)
    asked: Counter[int] = field(default_factory=Counter)
    sent: list[tuple[int, LinkHeard]] = field(default_factory=list)
    views: int = 0
    cut_off: set[int] = field(default_factory=set)
    """Robots whose link messages are all lost."""
    is_checked: bool = True
    """Whether hulls must keep off the obstacles; not where the stage puts one beside a robot."""
    bodies: dict[int, Body] = field(init=False)
    parts: dict[int, Part] = field(init=False)
    members: dict[int, Member] = field(init=False)
    _chance: Random = field(init=False)
    _numbers: Counter[tuple[int, int]] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self._chance = Random(self.seed)
        self.bodies = {robot: Body(robot, at.x_m, at.y_m) for robot, at in self.places.items()}
        self.parts = {}
        for robot in self.places:
            driver = Driver(speed_mps=self.mission.speed_mps, watched=self.mission.obstacles_move)
            self.parts[robot] = Part(driver, Senses(self.mission, driver), Memory(self.mission))
        self.members = {}
        path = queue_path(self.order, self.places)
        zero = self.places[self.order[-1]]
        places_m = {
            robot: math.hypot(at.x_m - zero.x_m, at.y_m - zero.y_m) for robot, at in self.places.items()
        }
        self.form(path, {robot: places_m[robot] for robot in self.order})

    # --- views --------------------------------------------------------------------------------------

    @property
    def epoch(self) -> Epoch:
        return Epoch(generation=self.views, robot=self.order[0], life=life_of(self.order[0]))

    @property
    def leader(self) -> Member:
        return self.members[self.order[0]]

    def form(
        self, path: Path, places_m: Mapping[int, float], *, driven: bool = False, back_by_m: float = 0.0
    ) -> None:
        """Put the fence and give each robot its formation."""
        self.views += 1
        fence = fence_all(self.epoch, leader=self.order[0], members=len(self.order))
        self._put(fence)
        old = self.members
        self.members = {}
        newest = max(self.order, key=lambda robot: self.parts[robot].memory.number)
        for robot in self.order:
            told = formation(
                robot,
                self.order,
                {each: body.pose for each, body in self.bodies.items()},
                places_m,
                path,
                epoch=self.epoch,
                driven=driven,
                back_by_m=back_by_m,
                counters=self.counters,
                heals=bool(old) and len(old) != len(self.order),
            )
            if robot == self.order[0]:
                memory = self.parts[newest].memory
                told = replace(told, map_number=memory.number, seen=memory.seen)
            self.join(robot, told, path.copy())

    def join(self, robot: int, told: Formation, path: Path) -> Member:
        """The robot becomes a member of a formation."""
        part = self.parts[robot]
        self.members[robot] = Member(
            robot,
            mission=self.mission,
            driver=part.driver,
            senses=part.senses,
            memory=part.memory,
            formation=told,
            path=path,
            now_s=self.now_s,
        )
        return self.members[robot]

    def stop(self) -> None:
        """A raise has been taken: all bodies stand and drop their orders."""
        self._put(Fence(epoch=Epoch(generation=self.views + 1)))

    def reform(self, turnabout: Turnabout | None = None, *, counters: Counters | None = None) -> None:
        """A view with the same robots, at the places where they stand now."""
        self.stop()
        at_m = {robot: member.progress_m for robot, member in self.members.items()}
        path, back_by_m = self.leader.path, 0.0
        self.counters = self.leader.counters if counters is None else counters
        if turnabout is None:
            back = path.reversed(0.0, at_m[self.order[0]])
            path = back.reversed(0.0, back.end_m)
        else:
            path = path.reversed(turnabout.cut_m, turnabout.end_m)
            at_m = {robot: turnabout.end_m - s_m for robot, s_m in at_m.items()}
            self.order, back_by_m = self.order[::-1], turnabout.back_by_m
        self.form(path, at_m, driven=True, back_by_m=back_by_m)

    def _put(self, fence: Fence) -> None:
        for robot, body in self.bodies.items():
            body.fenced(fence)
            self.parts[robot].driver.hear(body.odometry(self.now_s))

    # --- what happens -------------------------------------------------------------------------------

    def run(self, for_s: float, *, turns: bool = False) -> None:
        """Let time pass; with `turns`, a robot that wants the strand to turn round gets its view."""
        for _ in range(round(for_s / PERIOD_S)):
            self.tick()
            reason = self.leader.reason
            if turns and reason is not None and reason.cause is Cause.DEAD_END:
                self.reform(reason.turnabout)
            if all(member.arrived for member in self.members.values()):
                return

    def tick(self) -> None:
        self.now_s = round(self.now_s + PERIOD_S, 6)
        for body in self.bodies.values():
            body.live(PERIOD_S)
        self.check()
        for robot in self._chance.sample(self.order, len(self.order)):
            self.wake(robot)
        self.deliver()

    def wake(self, robot: int) -> list[Command]:
        """The robot hears odometry."""
        self.parts[robot].driver.hear(self.bodies[robot].odometry(self.now_s))
        return self._do(robot, self.members[robot].act(self.now_s))

    def deliver(self) -> None:
        """Deliver what is in transit, but for what is lost or late."""
        transit, self.sent = self.sent, []
        for receiver, heard in transit:
            if {receiver, heard.robot} & self.cut_off or self._chance.random() < self.loss:
                continue
            if self._chance.random() < self.odd:
                self.sent.append((receiver, heard))
                if self._chance.random() < 0.5:
                    continue
            self.give(receiver, heard)

    def give(self, receiver: int, heard: LinkHeard) -> list[Command]:
        """A link message arrives."""
        member = self.members[receiver]
        return self._do(receiver, member.hear(heard, self.now_s) + member.act(self.now_s))

    def scan(self, robot: int, revolutions: int = 1) -> Scan:
        """What the robot's sensor sees now."""
        body = self.bodies[robot]
        radius_m = self.mission.robot_radius_m
        discs = [(each.x_m, each.y_m, radius_m) for each in self.bodies.values() if each is not body]
        ranges_m = cast(
            ground_of(self.shapes),
            np.array([body.x_m, body.y_m]),
            scan_bearings_rad(revolutions * self.mission.directions),
            range_m_max=self.mission.range_m_max,
            discs=np.array(discs).reshape(-1, 3),
        )
        return Scan(t_s=self.now_s, pose=body.pose, fence=body.fence, ranges_m=tuple(ranges_m.tolist()))

    def _do(self, robot: int, commands: list[Command]) -> list[Command]:
        """Obey the commands; a scan that is asked for comes at once."""
        part = self.parts[robot]
        done = list(commands)
        while commands:
            asked = [command for command in commands if isinstance(command, AskScan)]
            for command in commands:
                match command:
                    case Tell(to, state):
                        self._numbers[robot, to] += 1
                        self.sent.append((to, LinkHeard(robot, self._numbers[robot, to], state)))
                    case Note(record):
                        self.told.append((robot, record))
                    case _:
                        pass
            commands = []
            for ask in asked:
                self.asked[robot] += 1
                part.senses.hear(self.scan(robot, ask.revolutions))
                commands += self.members[robot].act(self.now_s)
            done += commands
        self.bodies[robot].take(part.driver.drive)
        return done

    # --- what must hold -----------------------------------------------------------------------------

    def check(self) -> None:
        """No hull comes too near another, or an obstacle."""
        for a, b in combinations(self.bodies.values(), 2):
            apart_m = math.hypot(a.x_m - b.x_m, a.y_m - b.y_m) - 2.0 * self.mission.robot_radius_m
            least_m = self.mission.separation_m - self.mission.mu0_m
            assert apart_m >= least_m, f"robots {a.robot} and {b.robot} are {apart_m:.4f} m apart"
        if not (self.shapes and self.is_checked):
            return
        places = np.array([[body.x_m, body.y_m] for body in self.bodies.values()])
        least_m = float(clearance(ground_of(self.shapes), places, places).min()) - self.mission.robot_radius_m
        assert least_m >= self.mission.epsilon_m - self.mission.mu0_m - ON_THE_SPOT_M

    def records(self, kind: type[T]) -> list[T]:
        return [record for _, record in self.told if isinstance(record, kind)]

    def newest_ahead(self, robot: int) -> AheadState:
        """What the robot has told last to the robot behind it, if that is in transit."""
        return next(
            heard.state
            for _, heard in reversed(self.sent)
            if heard.robot == robot and isinstance(heard.state, AheadState)
        )


def row(robots: int, *, spacing_m: float = 0.5, x_m: float = 0.0) -> dict[int, Pose]:
    """Robots in a row along the x axis, number 1 in front."""
    return {
        robot: Pose(x_m=x_m - spacing_m * (robot - 1), y_m=0.0, heading_rad=0.0)
        for robot in range(1, robots + 1)
    }
