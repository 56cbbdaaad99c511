"""What a run's timeline adds up to while it is written: entries in, a head and rows out. Pure.

Rule 1: all is from the timeline alone. Clearances are of true poses, as the verdict's, and come to the same.
Rule 2: a message counts as lost at the robot that was to hear it, and an order that the world was to hear at
        the robot that gave it. Only what a fault plan takes away is known before the books are balanced.
Rule 3: how much of its way a robot has behind it is known along the path of its strand, as far as its leader
        has planned, and from there by that plan. While its strand has no plan, a robot keeps what it had.
"""

from collections import Counter, defaultdict, deque
from dataclasses import dataclass, field
from typing import Self

import msgspec

from clew.story.motion import Motion
from clew.story.standing import Standing, State
from clew.story.way import Course, along_m
from protocol.frames import Point
from protocol.keys import robot_number
from protocol.timeline import (
    Entry,
    FaultInjected,
    OrderAccepted,
    PoseSampled,
    PromiseBroken,
    Record,
    RunEnded,
    StepPlanned,
    StrandFormed,
)
from world.judge.verdict import finite
from world.record.progress import progress
from world.record.recorder import Header
from world.scenario.scenario import Scenario

NO_PROCESS = (State.DEAD, State.KILLED, State.FAILED)
EVENTS_KEPT = 10  # more than there is room for below a table
TAKING = ("drop", "partition", "corrupt")  # faults that leave nothing lawful of a message
IN_BOOKS = ("link", "muster", "drive", "odometry")  # the first or the last part of keys that are


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One robot, now."""

    robot: int
    place: int | None
    """In the strand; the leader's is 0."""
    state: State
    about: tuple[int, ...]
    """The neighbours for which it waits."""
    step: int | None
    """The switching step on whose ground it is."""
    driven_m: float
    share: float | None
    """How much of its way to the goal it has behind it; None: not known yet, or there is no goal."""
    clearance_m: float | None
    """Of its hull; None: not seen yet, or there is no obstacle."""
    clearance_m_min: float | None
    lost: int
    """Messages to it, and orders of its."""


@dataclass(slots=True)
class _Way:
    """What a row keeps while nothing newer is known."""

    step: int | None = None
    share: float | None = None


@dataclass(slots=True)
class Scoreboard:
    """One run."""

    header: Header
    motion: Motion
    standings: dict[int, Standing]
    t_s: float = 0.0
    step: int = 0
    """The newest that was planned."""
    epoch: int = 0
    """The newest in which a strand has formed."""
    broken: int = 0
    ended: str | None = None
    events: deque[str] = field(default_factory=lambda: deque(maxlen=EVENTS_KEPT))
    """What people wait for, the newest last."""
    _courses: dict[int, Course] = field(default_factory=dict)
    _orders: dict[int, OrderAccepted] = field(default_factory=dict)
    _ways: defaultdict[int, _Way] = field(default_factory=lambda: defaultdict(_Way))
    _lost: Counter[int] = field(default_factory=Counter)

    @classmethod
    def of(cls, header: Header) -> Self:
        """The board of a run that has begun.

        Raises:
            msgspec.ValidationError: the header's scenario is none of this version.
        """
        scenario = msgspec.convert(header.scenario, Scenario)
        motion = Motion(scenario.ground, scenario.fleet.robot_radius_m)
        robots = range(1, scenario.fleet.robots + 1)
        return cls(header, motion, {robot: Standing(robot) for robot in robots})

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        self.t_s = max(self.t_s, entry.t_s)
        if (said := progress(source, entry)) is not None:
            self.events.append(said)
        if not self._knows(source, entry.record):
            return
        match entry.record:
            case PoseSampled(robot=robot) as pose:
                if self.motion.see(robot, Point(x_m=pose.x_m, y_m=pose.y_m)):
                    self.standings[robot].move()
                    self._come_on(robot)
            case OrderAccepted(robot=robot) as order:
                self._orders[robot] = order
                self._come_on(robot)
            case FaultInjected(key=str(key)) as fault:
                self._lose(source, key, fault)
            case PromiseBroken():
                self.broken += 1
            case RunEnded(reason=reason):
                self.ended = reason
            case _:
                self._hear_of_robots(source, entry.record)

    def _knows(self, source: str, record: Record) -> bool:
        """Whether all robots of an entry are the fleet's: a log may name others."""
        process = getattr(record, "process", None) or ""
        named = (robot_number(source), robot_number(process), getattr(record, "robot", None))
        return all(robot is None or robot in self.standings for robot in named)

    def _hear_of_robots(self, source: str, record: Record) -> None:
        speaker = robot_number(source)
        if isinstance(record, FaultInjected):
            struck = robot_number(record.process or "")
            if struck is not None:
                self.standings[struck].hear_world(record)
        elif speaker is not None:
            self.standings[speaker].hear_itself(record)
            self._hear_of_the_way(self.standings[speaker], record)
        elif (robot := getattr(record, "robot", None)) is not None:
            self.standings[robot].hear_world(record)

    def _hear_of_the_way(self, speaker: Standing, record: Record) -> None:
        match record:
            case StrandFormed(epoch=epoch, path_length_m=start_m):
                self._courses.setdefault(epoch, Course(start_m))
                self.epoch = max(self.epoch, epoch)
                in_use = {standing.epoch for standing in self.standings.values()}
                self._courses = {each: course for each, course in self._courses.items() if each in in_use}
            case StepPlanned(epoch=epoch, joins=False) as plan if (
                speaker.place == 0 and speaker.epoch == epoch
            ):
                self._courses[epoch].plan(plan)
                self.step = max(self.step, plan.step)
            case _:
                pass  # nothing of the way

    def _come_on(self, robot: int) -> None:
        """Rule 3: a robot has moved, or is to."""
        standing, way = self.standings[robot], self._ways[robot]
        course, order = self._courses.get(standing.epoch), self._orders.get(robot)
        track = self.motion.tracks.get(robot)
        if course and order and track and standing.formed and order.epoch == standing.epoch:
            here_m = along_m(order, track.at)
            way.step = course.step_at(here_m) or way.step
            if course.goal_m is not None and course.goal_m > here_m:
                way.share = track.driven_m / (track.driven_m + course.goal_m - here_m)

    def _lose(self, source: str, key: str, fault: FaultInjected) -> None:
        """Rule 2."""
        parts = key.split("/")
        if fault.fault in TAKING and (parts[0] in IN_BOOKS or parts[-1] in IN_BOOKS):
            robot = robot_number(source) or robot_number(parts[min(1, len(parts) - 1)])
            if robot is not None:
                self._lost[robot] += 1

    @property
    def rows(self) -> list[Row]:
        """All robots: the strand from its leader to its tail, then those that have no place in it."""
        self.motion.measure()
        rows = [self._row(standing) for standing in self.standings.values()]
        return sorted(rows, key=lambda row: (row.place is None, row.place, row.robot))

    def _row(self, standing: Standing) -> Row:
        robot, track = standing.robot, self.motion.tracks.get(standing.robot)
        way, state = self._ways[robot], standing.state
        return Row(
            robot=robot,
            place=None if standing.gone in NO_PROCESS else standing.place,
            state=state,
            about=tuple(sorted(standing.silent)) if state is State.WAITING else (),
            step=way.step,
            driven_m=0.0 if track is None else track.driven_m,
            share=1.0 if standing.arrived else way.share,
            clearance_m=None if track is None else finite(track.clearance_m),
            clearance_m_min=None if track is None else finite(track.clearance_m_min),
            lost=self._lost[robot],
        )
