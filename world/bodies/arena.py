"""The arena: all bodies, their sensors and the monitor, in simulated time, with the entries about them.

Rule 1: simulated time advances only by ticks.
Rule 2: a body is sampled where its motion changes, and before every odometry while it moves. So between
        samples it moved straight at constant speed, and the samples alone give the least distances.
Rule 3: the monitor judges every tick that its guard has not found safe.
Rule 4: a change of the fence is recorded before anything is told or obeyed under it. All bodies stand then.
Rule 5: odometry of a body is numbered. A resumed world continues above every number that was told before.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from protocol.fence import Change, Fence, May
from protocol.frames import Pose
from protocol.timeline import (
    BodyStopped,
    OrderAccepted,
    OrderFinished,
    OrderRefused,
    PoseSampled,
    Record,
    ScanServed,
    StepFinished,
)
from protocol.wire.messages import Drive, Odometry, Phase, Scan
from world.bodies.bodies import Bodies, Moves, Start
from world.bodies.fence import Register, Taken
from world.bodies.guard import SMALL_FLEET, Guard, Place
from world.bodies.sensor import Sensor, told
from world.chance import stream
from world.commands import Note
from world.geometry.clearance import clearance
from world.geometry.rays import NearDiscs
from world.judge.monitor import Monitor
from world.record.resume import QUIET_S, BodyPast, Past
from world.scenario.scenario import Scenario

TICK_S = 0.02  # docs/run.md
ODOMETRY_TICKS = 5  # 0.1 s: docs/run.md
TOLD_PER_TICK_MAX = 1000  # odometry of one body: one for a tick, and one for each change of the fence in it
ROUNDING_S = 1e-9  # error of sums over ticks


class Arena:
    """Robot k is row k - 1 of all arrays."""

    def __init__(self, scenario: Scenario, *, seed: int, life: int = 0) -> None:
        """A world that is resumed for the n-th time uses the random streams of life n."""
        robots = range(1, scenario.fleet.robots + 1)
        of_life = f"/{life}" if life else ""
        self._speed_mps = scenario.drive.speed_mps
        self.bodies = Bodies(
            scenario.fleet.poses(),
            scenario.drive,
            [stream(seed, f"drive/{robot}{of_life}") for robot in robots],
        )
        self.moved_s = 0.0
        """The time of the last motion of any body."""
        self.turn_s = 0.0
        """When a robot last got a turn, in which it may look for long, or the operator held the fleet."""
        self._register = Register(len(robots))
        self._told = [0] * len(robots)
        """The number of the newest odometry of each body."""
        self._sensor = Sensor(scenario, [stream(seed, f"scan/{robot}{of_life}") for robot in robots])
        self._monitor = Monitor.of(scenario)
        self.guard = Guard(self._monitor.promises, scenario.ground, len(robots))
        """What it keeps in a small fleet follows from the ground alone."""
        self._ground = scenario.ground
        self._radius_m = scenario.fleet.robot_radius_m
        self._corners_m: list[list[Place]] = [[] for _ in robots]
        """The corners of each body's way since it accepted its order, with the place of acceptance."""
        self._steps = [0] * len(robots)
        self._finished: list[tuple[int, int] | None] = [None] * len(robots)
        """The last finished step of each body, by epoch and step: a finished step may be ordered again."""
        self._ticks = 0
        self.now_s = 0.0
        """Simulated time."""
        self._noted_s = math.inf
        """When something was last recorded of bodies; infinite until they are placed."""
        self._follows_scans = False
        self._scanned: set[int] = set()
        self._sampled: Sequence[int] = ()
        """The bodies that were sampled at the end of the last tick."""

    @property
    def is_odometry_instant(self) -> bool:
        """Whether odometry is sent to robots now."""
        return self._ticks % ODOMETRY_TICKS == 0

    @property
    def instant(self) -> int:
        """How many odometry instants have passed."""
        return self._ticks // ODOMETRY_TICKS

    @property
    def fence(self) -> Fence:
        """What all bodies obey."""
        return self._register.fence

    @property
    def stood_s(self) -> float:
        """For how long every body has stood."""
        return 0.0 if self.bodies.any_moves else self.now_s - self.moved_s

    def share_ground(self, others: NearDiscs) -> None:
        """See the hulls of other fleets, too."""
        self._sensor.share_ground(others)

    def note(self, record: Record) -> Note:
        """A record with the present time."""
        return Note(self.now_s, record)

    def place(self) -> list[Note]:
        """Judge and record the initial positions of the bodies."""
        places_m, self._noted_s = self.bodies.place_m, self.now_s
        broken = self._monitor.watch(places_m, places_m, t_s=self.now_s)
        return self.sample() + [self.note(each) for each in broken]

    def resume(self, past: Past) -> list[Note]:
        """Resume from a timeline: bodies stand at their last recorded poses, which are recorded again."""
        self._go_to(round(past.newest_s / TICK_S))
        for robot, known in past.bodies.items():
            self._stand_as(robot - 1, known)
        # Bodies were there at that time, before the next recorded one.
        notes = self._samples([robot - 1 for robot, known in past.bodies.items() if not known.sampled])
        instants = math.ceil((past.newest_s + QUIET_S - ROUNDING_S) / (TICK_S * ODOMETRY_TICKS))
        self._go_to(instants * ODOMETRY_TICKS)
        self._noted_s = self.moved_s = self.now_s
        self._told = [self._ticks * TOLD_PER_TICK_MAX] * len(self._told)
        self._register = Register(len(self._told), past.fence, past.quotas)
        return notes

    def restart_fence(self) -> list[Note]:
        """The world has been started again: nothing that was ordered or put before counts."""
        return self._change(self._register.restart(now_s=self.now_s))

    def put(self, robot: int, change: Change) -> list[Note]:
        """Process a put of a robot, or of the operator; no notes: it changes nothing."""
        taken = self._register.put(robot, change, now_s=self.now_s)
        return [] if taken is None else self._change(taken)

    def _change(self, taken: Taken) -> list[Note]:
        """Rule 4; the poses are those at which bodies stop in the middle of a motion."""
        moving = self.bodies.movers
        samples = self._samples(moving)
        if moving:
            self.moved_s = self.now_s
        self._sampled = [*self._sampled, *moving]
        if self.fence.may is May.ONE:
            self.turn_s = self.now_s
        self.bodies.stand()
        return [*samples, self.note(taken.as_record())]

    def _stand_as(self, body: int, known: BodyPast) -> None:
        pose = Pose(x_m=known.x_m, y_m=known.y_m, heading_rad=known.heading_rad)
        self.bodies.resume(body, pose, ordered=known.ordered, finished=known.finished, now_s=self.now_s)

    def sample(self) -> list[Note]:
        """Record the poses of all bodies."""
        return self._samples(range(len(self.bodies)))

    def sample_told(self, robots: Iterable[int]) -> list[Note]:
        """Record the poses of these robots' bodies that move, if they are told between two samples.

        A resumed world knows no later pose than the newest recorded one (`world.record.resume`, rule 1).
        """
        if self.is_odometry_instant:
            return []  # recorded by the tick
        moving = [robot - 1 for robot in robots if self.bodies.is_moving(robot - 1)]
        self._sampled = [*self._sampled, *moving]
        return self._samples(moving)

    def _samples(self, bodies: Sequence[int]) -> list[Note]:
        """The poses of these bodies now."""
        return [self.note(each) for each in self._poses(bodies, {})]

    def _poses(self, bodies: Sequence[int], starts: dict[int, Start]) -> list[PoseSampled]:
        """The entries of these bodies, with how near each is to obstacles and to other bodies.

        Args:
            bodies: the bodies.
            starts: where some of all bodies were, if not where they are now.
        """
        if not bodies:
            return []
        places = self.bodies.places
        for body, start in starts.items():
            places[body] = start[:2]
        return [
            PoseSampled(
                robot=body + 1,
                x_m=places[body][0],
                y_m=places[body][1],
                heading_rad=starts[body].heading_rad if body in starts else self.bodies[body].heading_rad,
                clearance_m=_to_the_micrometre(self.guard.clearance_m(body, places[body]) - self._radius_m),
                separation_m=_to_the_micrometre(near_m - 2.0 * self._radius_m),
            )
            for body, near_m in zip(bodies, _nearest_m(bodies, places), strict=True)
        ]

    def order(self, robot: int, drive: Drive) -> list[Note]:
        """Give a body an order; raises `MessageRefusedError` if it is void."""
        body = robot - 1
        if not self.bodies.hear(body, drive, self.fence, now_s=self.now_s):
            return []
        if drive.target is not None:  # an order to stand interrupts a step, which is measured as a whole
            if drive.step == 0 or drive.step != self._steps[body]:
                self._corners_m[body] = [self.bodies.places[body]]
            self._steps[body] = drive.step
        pose = self.bodies.pose(body)
        accepted = OrderAccepted(
            robot=robot,
            number=drive.number,
            epoch=drive.bearing.epoch.number,
            turn=drive.bearing.turn,
            life=f"{drive.bearing.life:x}",
            step=drive.step,
            x_m=pose.x_m,
            y_m=pose.y_m,
            target=drive.target,
            reach_m=drive.reach_m,
        )
        return [self.note(accepted)]

    def refusal(self, robot: int, drive: Drive, reason: str) -> Note:
        """The entry of an order that a body has refused."""
        refused = OrderRefused(
            robot=robot,
            number=drive.number,
            epoch=drive.bearing.epoch.number,
            turn=drive.bearing.turn,
            fence=self.fence.epoch.number,
            fence_turn=self.fence.turn,
            reason=reason,
        )
        return self.note(refused)

    def scan(self, robot: int, revolutions: int) -> tuple[Note, Scan]:
        """Take a scan of so many revolutions, or as many as fit into a scan."""
        pose = self.bodies.pose(robot - 1)
        scan, ranges_m = self._sensor.read(
            robot - 1,
            pose,
            self.bodies.place_m,
            fence=self.fence,
            now_s=self.now_s,
            revolutions=revolutions,
        )
        served = ScanServed(
            robot=robot,
            x_m=pose.x_m,
            y_m=pose.y_m,
            heading_rad=pose.heading_rad,
            revolutions=len(ranges_m) // self._sensor.directions,
            hits=self._sensor.hits(ranges_m),
            ranges_m=told(ranges_m),
        )
        if self._follows_scans and self.is_odometry_instant:  # odometry after a scan brings the next scan
            self._scanned.add(robot)
        return self.note(served), scan

    def follow_scans(self, follows: bool) -> None:
        """Say whether robots are told odometry a tick after a scan, which may permit no more than two."""
        self._follows_scans = follows

    def take_scanned(self) -> set[int]:
        """Remove and return the robots to be told odometry after their scans."""
        scanned, self._scanned = self._scanned, set()
        return scanned

    def odometry(self, robot: int, phase: Phase, *, stood_s: float) -> Odometry:
        """The next odometry of a body for its robot."""
        body = robot - 1
        self._told[body] += 1
        return Odometry(
            n=self._told[body],
            t_s=self.now_s,
            pose=self.bodies.pose(body),
            moving=self.bodies.is_moving(body),
            finished=self.bodies[body].finished_number,
            ordered=self.bodies[body].ordered,
            fence=self.fence,
            stood_s=stood_s,
            phase=phase,
        )

    def tick(self) -> tuple[list[Note], list[int]]:
        """Advance by one tick; returns the entries, and the robots whose bodies have finished an order."""
        began_s, moving = self.now_s, self.bodies.movers
        moves = self.bodies.tick(now_s=began_s, tick_s=TICK_S)
        for body in moves.veered:
            self._corners_m[body].append(moves.starts[body][:2])
        unsampled = [body for body in moves.veered if body not in self._sampled]
        notes = [Note(began_s, each) for each in self._poses(unsampled, moves.starts)]
        self._go_to(self._ticks + 1)
        notes += self._sample_moved(moving)
        notes += [self.note(BodyStopped(robot=body + 1)) for body in moves.stopped]
        notes += self._watch(moves)
        notes += [self.note(record) for body in moves.finished for record in self._finish(body)]
        if moving:
            self.moved_s = self.now_s
        if self.fence.may is May.STOPPED:
            self.turn_s = self.now_s
        if notes:
            self._noted_s = self.now_s
        return notes, [body + 1 for body in moves.finished]

    def _go_to(self, ticks: int) -> None:
        self._ticks = ticks
        self.now_s = round(ticks * TICK_S, 9)  # 4.02 and not 4.0200000000000005

    def _sample_moved(self, moved: Sequence[int]) -> list[Note]:
        """The samples to record before odometry is sent; at least one per `QUIET_S`."""
        if not self.is_odometry_instant:
            self._sampled = ()
            return []
        is_quiet = not moved and self.now_s - self._noted_s >= QUIET_S - ROUNDING_S
        self._sampled = (0,) if is_quiet else moved
        return self._samples(self._sampled)

    def _watch(self, moves: Moves) -> list[Note]:
        """Rule 3."""
        is_safe = self.guard.are_safe(self.bodies, moves) and self._monitor.is_calm  # asked at every tick
        if is_safe and not self._monitor.movers.names:
            return []
        starts_m, ends_m = self.bodies.place_m, self.bodies.place_m
        for body, start in moves.starts.items():
            starts_m[body] = start[:2]
        broken = self._monitor.watch(starts_m, ends_m, t_s=self.now_s, is_safe=is_safe)
        return [self.note(each) for each in broken]

    def _order_clearance_m(self, body: int) -> float | None:
        """The least clearance of a hull since its body accepted its order; None without obstacles."""
        way_m = np.array([*self._corners_m[body], self.bodies.places[body]])
        least_m = float(clearance(self._ground, way_m[:-1], way_m[1:]).min()) - self._radius_m
        return least_m if least_m < np.inf else None

    def _finish(self, body: int) -> list[Record]:
        order = self.bodies.orders[body]
        assert order is not None, f"body {body} finished without an order"
        pose = self.bodies.pose(body)
        clearance_m = self._order_clearance_m(body)
        x_m, y_m = pose.x_m, pose.y_m
        done = OrderFinished(
            robot=body + 1,
            number=order.number,
            step=order.step,
            x_m=x_m,
            y_m=y_m,
            clearance_m=clearance_m,
        )
        ordered = order.bearing.epoch.number, order.step
        if order.step == 0 or self._finished[body] == ordered:
            return [done]
        self._finished[body] = ordered
        step = StepFinished(robot=body + 1, step=order.step, x_m=x_m, y_m=y_m, clearance_m=clearance_m)
        return [done, step]


def _nearest_m(bodies: Sequence[int], places: list[Place]) -> list[float]:
    """How far each of these bodies is from the nearest other one; in a large fleet by arrays."""
    if len(places) > SMALL_FLEET:
        all_m = np.array(places)
        x, y = (np.subtract.outer(column[list(bodies)], column) for column in all_m.T)
        squares = x * x + y * y
        squares[np.arange(len(bodies)), bodies] = math.inf
        nearest_m: list[float] = np.sqrt(squares.min(axis=1)).tolist()
        return nearest_m
    return [_nearest_of_few_m(body, places) for body in bodies]


def _nearest_of_few_m(body: int, places: list[Place]) -> float:
    x_m, y_m = places[body]
    least = math.inf
    for other, (x, y) in enumerate(places):
        square = (x - x_m) * (x - x_m) + (y - y_m) * (y - y_m)
        if square < least and other != body:
            least = square
    return math.sqrt(least)


def _to_the_micrometre(distance_m: float) -> float | None:
    """The distance as recorded; None: there was nothing to measure to."""
    return round(distance_m, 6) if distance_m < math.inf else None
