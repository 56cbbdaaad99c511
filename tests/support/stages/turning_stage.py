"""Robots of a strand that reverses, over an arbitrarily bad network. Not a test file.

The robots' parts (`agents.strand.member`) are the real ones. Bodies obey their orders late; messages come in
any order, more than once, or never. The stage decides what the leader plans: a step or a reversal.
"""

import math
from collections import Counter
from dataclasses import dataclass
from itertools import combinations, pairwise
from random import Random

import numpy as np
from agents.strand.forming import lined_up

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command, Note, Tell
from agents.events import LinkHeard
from agents.navigation.certificate import certified_lengths_m
from agents.strand.member import Member
from agents.strand.memory import Memory
from protocol.frames import Point, Pose
from protocol.mission import Law
from protocol.path import THERE_M
from protocol.timeline import AuthorityGranted
from protocol.wire.messages import Drive, Odometry, Phase, Reversal
from tests.support.stages.one_step import under

# No robot ever counts as silent: the claims must not depend on a lease. This law uses no scans. Links are
# short, so that robots are often stopped on their way.
MISSION = under(
    Law.PRINTED, robots=3, robot_radius_m=0.1, separation_m=0.1, silence_s=1e9, link_length_m_max=0.3
)
KEEP_M = MISSION.robot_keep_m
ORDER = (3, 2, 1)
AFTER_S = MISSION.heartbeat_s  # between two events, so that each one is sent
LOST, LATE = 0.3, 0.3  # shares of the messages in a round


@dataclass(slots=True)
class Body:
    """Drives straight to its current target, and takes a new order only after some motion."""

    x_m: float
    y_m: float
    order: Drive
    finished: int = 0

    def drive(self, share: float) -> bool:
        """Drive a share of the remaining way; returns whether it moved."""
        target = self.order.target
        if target is None:
            self.finished = self.order.number
            return False
        before = (self.x_m, self.y_m)
        self.x_m += share * (target.x_m - self.x_m)
        self.y_m += share * (target.y_m - self.y_m)
        if share == 1.0:
            self.x_m, self.y_m, self.finished = target.x_m, target.y_m, self.order.number
        return (self.x_m, self.y_m) != before

    def take(self, order: Drive) -> None:
        self.order = order
        if order.target is None:
            self.finished = order.number


class TurningStage:
    """The robots, their bodies, and the messages in flight."""

    def __init__(self, spacing_m: float) -> None:
        places = {robot: Pose(x_m=spacing_m * robot, y_m=0.0, heading_rad=0.0) for robot in ORDER}
        self.now_s = 0.0
        self.drivers = {robot: Driver(speed_mps=MISSION.speed_mps) for robot in ORDER}
        self.bodies = {
            robot: Body(places[robot].x_m, places[robot].y_m, self.drivers[robot].drive) for robot in ORDER
        }
        self._began = {robot: (body.x_m, body.y_m) for robot, body in self.bodies.items()}
        self.members: dict[int, Member] = {}
        for robot, driver in self.drivers.items():
            strand = lined_up(robot, ORDER, places, MISSION, 0.0)
            self.members[robot] = Member(MISSION, driver, Senses(MISSION, driver), strand, Memory(MISSION))
            driver.hear(self._odometry(robot))
            driver.begin(strand.start_m)
        self.on_their_way: list[tuple[int, LinkHeard]] = []
        self.turns = 0
        self._numbers: Counter[tuple[int, int]] = Counter()

    @property
    def epochs(self) -> list[int]:
        """The epoch of each robot's place."""
        return [member.strand.epoch for member in self.members.values()]

    # --- what may happen ----------------------------------------------------------------------------

    def act(self, what: str, which: float, how: float) -> None:
        match what:
            case "live":
                self.live(int(which), how)
            case "deliver":
                self.deliver(int(which), again=how < 0.5)
            case "round":
                self.round(int(which))
            case "step":
                self.step(which, how)
            case _:
                self.turn(which)

    def round(self, seed: int) -> None:
        """All robots act; of the messages in flight some arrive, some are late, some are lost."""
        chance = Random(seed)
        for robot in chance.sample(ORDER, len(ORDER)):
            self.live(robot, chance.choice([1.0, 1.0, chance.random()]))
        for _ in range(len(self.on_their_way)):
            fate = chance.random()
            if fate < LOST:
                self.on_their_way.pop(chance.randrange(len(self.on_their_way)))
            elif fate < 1.0 - LATE:
                self.deliver(chance.randrange(len(self.on_their_way)), again=chance.random() < LATE)

    def live(self, robot: int, share: float) -> None:
        """A body drives on, then takes its newest order and sends its robot odometry."""
        body, driver = self.bodies[robot], self.drivers[robot]
        if body.drive(share):
            self._check_motion(robot, body.order)
        body.take(driver.drive)
        self._tick()
        driver.hear(self._odometry(robot))
        self._do(robot, self.members[robot].act(self.now_s))

    def deliver(self, index: int, *, again: bool) -> None:
        """Deliver one of the messages in flight; it may arrive again."""
        if not self.on_their_way:
            return
        at = index % len(self.on_their_way)
        receiver, heard = self.on_their_way[at] if again else self.on_their_way.pop(at)
        self._tick()
        member = self.members[receiver]
        self._do(receiver, member.hear(heard, self.now_s) + member.act(self.now_s))

    def step(self, length_m: float, heading_rad: float) -> None:
        """The leader plans a step that keeps its distance from all granted ground."""
        robot = self._first()
        if robot is None:
            return
        strand, driver = self.members[robot].strand, self.drivers[robot]
        if self._is_at_end(robot):
            strand.back_by_m = 0.0
            here = strand.path.at(strand.path.end_m)
            origin, walls = np.array([here.x_m, here.y_m]), strand.grants.ground.walls
            free_m = float(certified_lengths_m(origin, np.array([heading_rad]), walls)[0])
            x_m, y_m = origin + min(free_m, length_m) * np.array(
                [math.cos(heading_rad), math.sin(heading_rad)]
            )
            strand.growth.begin(Point(x_m=float(x_m), y_m=float(y_m)))
        driver.to(strand.path.at(strand.path.end_m), reach_m=strand.path.end_m, epoch=strand.epoch, step=1)

    def turn(self, share: float) -> None:
        """The leader reverses the strand, until it has come back by a share of the path."""
        robot = self._first()
        if robot is None or not self._is_at_end(robot):
            return
        end_m = self.drivers[robot].progress_m
        self.members[robot].strand.reverse(
            Reversal(cut_m=0.0, end_m=end_m, back_by_m=share * end_m, turns=1, seen=b"")
        )
        self.turns += 1

    # --- what must hold -----------------------------------------------------------------------------

    def check(self, spacing_m: float, rounding_m: float) -> None:
        apart_m = min(
            math.hypot(a.x_m - b.x_m, a.y_m - b.y_m) for a, b in combinations(self.bodies.values(), 2)
        )
        assert apart_m >= min(KEEP_M - MISSION.mu0_m, spacing_m) - rounding_m
        newest_epoch = max(self.epochs)
        assert newest_epoch - min(self.epochs) <= 1
        for robot, member in self.members.items():
            self._check_place(robot, member, rounding_m)
        newest = next(each.strand for each in self.members.values() if each.strand.epoch == newest_epoch)
        for ahead, behind in pairwise(newest.order):
            granter, granted = self.members[ahead].strand, self.members[behind].strand
            if granter.epoch == granted.epoch == newest.epoch:
                assert granted.authority_m <= granter.grants.granted_m + rounding_m
                shared = min(len(granter.path), len(granted.path))
                assert granted.path.told_from(0, shared) == granter.path.told_from(0, shared)

    def _check_place(self, robot: int, member: Member, rounding_m: float) -> None:
        """A standing robot knows its position along the path, and each robot knows whether it ever moved."""
        driver, body, path = self.drivers[robot], self.bodies[robot], member.strand.path
        assert member.has_moved or (body.x_m, body.y_m) == self._began[robot]
        if driver.standing:
            at = path.at(driver.progress_m)
            assert math.hypot(at.x_m - body.x_m, at.y_m - body.y_m) <= rounding_m

    def _check_motion(self, robot: int, order: Drive) -> None:
        strand = self.members[robot].strand
        assert strand.reversal is None, f"robot {robot} drives after it has forwarded the reversal"
        newest = max(self.epochs)
        assert order.epoch == strand.epoch == newest, (
            f"robot {robot} drives in epoch {order.epoch} of {newest}"
        )

    def _check_grant(self, robot: int, grant: AuthorityGranted) -> None:
        strand = self.members[robot].strand
        assert grant.epoch == strand.epoch
        assert grant.authority_m <= self.drivers[robot].progress_m, "granted ground that it has not yet left"

    # --- small things -------------------------------------------------------------------------------

    def _first(self) -> int | None:
        """The leader, if it stands and may plan."""
        newest = max(self.epochs)
        for robot, member in self.members.items():
            strand = member.strand
            leads = strand.ahead is None and strand.epoch == newest
            backs_up = strand.back_by_m > 0.0 and not self._is_at_end(robot)
            if (
                leads
                and not backs_up
                and not strand.silent
                and strand.reversal is None
                and self.drivers[robot].standing
            ):
                return robot
        return None

    def _is_at_end(self, robot: int) -> bool:
        return self.drivers[robot].progress_m >= self.members[robot].strand.path.end_m - THERE_M

    def _do(self, robot: int, commands: list[Command]) -> None:
        for command in commands:
            if isinstance(command, Tell):
                self._numbers[robot, command.robot] += 1
                heard = LinkHeard(robot, self._numbers[robot, command.robot], command.state)
                self.on_their_way.append((command.robot, heard))
            elif isinstance(command, Note) and isinstance(command.record, AuthorityGranted):
                self._check_grant(robot, command.record)

    def _tick(self) -> None:
        self.now_s += AFTER_S

    def _odometry(self, robot: int) -> Odometry:
        body = self.bodies[robot]
        pose = Pose(x_m=body.x_m, y_m=body.y_m, heading_rad=0.0)
        return Odometry(t_s=self.now_s, pose=pose, moving=False, finished=body.finished, phase=Phase.RUNNING)
