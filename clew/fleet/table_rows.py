"""The scoreboard of a run whose timeline is still being written: entries in, a head and rows out. Pure.

Rule 1: everything is derived from the timeline. Clearances use true poses and agree with the verdict's.
Rule 2: a robot's progress is the distance driven, as a share of that and the remaining way. The remaining way
        follows the strand's path as far as the leader has planned, then the plan's cost to go. While its
        strand has no plan, a robot keeps its last value.
"""

from collections import defaultdict, deque
from dataclasses import dataclass, field
from typing import Self

import msgspec

from clew.story.motion import Motion
from clew.story.robots import Robot
from clew.story.states import Conduct, Process, State
from clew.story.steps import along_m
from clew.story.story import Story
from protocol.fence import May
from protocol.frames import Point
from protocol.plain import plain
from protocol.timeline import Entry, FenceChanged, OrderAccepted, PoseSampled, PromiseBroken, RunEnded
from world.judge.verdict import finite
from world.record.progress import progress
from world.record.recorder import Header
from world.scenario.scenario import Scenario

NO_PROCESS = (Process.DEAD, Process.KILLED, Process.FAILED)
EVENTS_KEPT = 10  # more than fit below a table


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """The current state of one robot."""

    robot: int
    place: int | None
    """The place in the strand; the leader's is 0."""
    state: State
    about: tuple[int, ...]
    """The neighbours for which it waits."""
    step: int | None
    """The switching step of the ground that it is on."""
    driven_m: float
    share: float | None
    """Its progress to the goal, from 0 to 1; None: not known yet, or there is no goal."""
    clearance_m: float | None
    """The clearance of its hull; None: no pose yet, or there is no obstacle."""
    clearance_m_min: float | None
    lost: int
    """Lost messages to it and lost orders from it."""


@dataclass(frozen=True, slots=True)
class _Way:
    """The values that a row keeps until there are newer ones."""

    step: int | None = None
    share: float | None = None


@dataclass(slots=True)
class Scoreboard:
    """The state of one run."""

    header: Header
    motion: Motion
    robots: range
    story: Story = field(default_factory=Story)
    broken: int = 0
    is_stopped: bool = False
    """Whether the operator has stopped all bodies."""
    ended: str | None = None
    events: deque[str] = field(default_factory=lambda: deque(maxlen=EVENTS_KEPT))
    """The events of interest, the newest last."""
    _orders: dict[int, OrderAccepted] = field(default_factory=dict)
    _ways: defaultdict[int, _Way] = field(default_factory=lambda: defaultdict(_Way))

    @classmethod
    def of(cls, header: Header) -> Self:
        """The board of a run that has begun.

        Raises:
            msgspec.ValidationError: the header's scenario is of another version.
        """
        scenario = msgspec.convert(header.scenario, Scenario)
        motion = Motion(scenario.ground, scenario.fleet.robot_radius_m)
        return cls(header, motion, range(1, scenario.fleet.robots + 1))

    @property
    def t_s(self) -> float:
        """The latest time of an entry."""
        return self.story.end_s

    @property
    def step(self) -> int:
        """The newest planned step."""
        return self.story.steps.newest

    @property
    def epoch(self) -> int:
        """The newest epoch in which a strand has formed."""
        return max(self.story.strands.formed, default=0)

    def hear(self, source: str, entry: Entry) -> None:
        """Add an entry."""
        self.story.hear(source, entry)
        if (said := progress(source, entry)) is not None:
            self.events.append(plain(said))
        match entry.record:
            case PoseSampled(robot=robot) as pose:
                if self.motion.see(robot, Point(x_m=pose.x_m, y_m=pose.y_m)):
                    self._come_on(robot)
            case OrderAccepted(robot=robot) as order:
                self._orders[robot] = order
                self._come_on(robot)
            case PromiseBroken():
                self.broken += 1
            case FenceChanged(may=may):
                self.is_stopped = may is May.STOPPED
            case RunEnded(reason=reason):
                self.ended = plain(reason)
            case _:
                pass  # the story handles it

    def _come_on(self, number: int) -> None:
        """Rule 2: update a robot's progress after a motion or an order."""
        robot, way = self.story.robots.of(number), self._ways[number]
        strand, order = self.story.steps.ways.get(robot.epoch), self._orders.get(number)
        track = self.motion.tracks.get(number)
        is_in_strand = robot.conduct in {Conduct.MEMBER, Conduct.BACKING_UP, Conduct.ARRIVED}
        if not strand or not order or not track or not is_in_strand:
            return
        if (order.epoch, order.turn) == (robot.epoch, strand.turn):
            here_m = along_m(order, track.at)
            step, share = strand.step_at(here_m) or way.step, way.share
            if strand.goal_m is not None and strand.goal_m > here_m:
                share = track.driven_m / (track.driven_m + strand.goal_m - here_m)
            self._ways[number] = _Way(step, share)

    @property
    def rows(self) -> list[Row]:
        """All robots: the strand from its leader to its tail, then the robots without a place in it."""
        self.motion.measure()
        rows = [self._row(self.story.robots.of(robot)) for robot in self.robots]
        return sorted(rows, key=lambda row: (row.place is None, row.place, row.robot))

    def _row(self, robot: Robot) -> Row:
        number, state = robot.number, robot.state
        way, track = self._ways[number], self.motion.tracks.get(number)
        _, pose = self.story.poses.get(number, (0.0, None))
        return Row(
            robot=number,
            place=None if robot.process in NO_PROCESS else robot.place,
            state=state,
            about=robot.silent if state is State.WAITING else (),
            step=way.step,
            driven_m=0.0 if track is None else track.driven_m,
            share=1.0 if robot.conduct is Conduct.ARRIVED else way.share,
            clearance_m=None if pose is None else pose.clearance_m,
            clearance_m_min=None if track is None else finite(track.clearance_m_min),
            lost=self.story.losses.by_robot[number],
        )
