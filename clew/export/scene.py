"""The scene of a run, derived from its entries; things that change are drawn again. Pure.

Rule 1: entries come in the order of their times.
Rule 2: things that move with a robot are drawn once, in the robot's frame. Links between robots and moving
        obstacles are drawn again every `PERIOD_S`.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

from clew.export.drawing import Colour, Disc, Label, Stroke, Thing, capsule, outline
from clew.log.check import scenario_of
from clew.log.log import Log
from clew.story.forming import Forming
from clew.story.robots import Robots
from clew.story.steps import chosen_gap
from protocol.errors import UsageError
from protocol.frames import Point
from protocol.keys import robot_number
from protocol.path import Path
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    PoseSampled,
    PromiseBroken,
    StepPlanned,
)
from world.scenario.scenario import Scenario

PERIOD_S = 0.1  # the period of odometry
DOT_SHARE = 0.2  # of its halo: the disc of a robot with radius 0
GROUND = Colour(0.45, 0.45, 0.5)
MOVING = Colour(0.9, 0.55, 0.1)
GOAL = Colour(0.1, 0.65, 0.3)
ROBOT, DEAD, BROKEN = Colour(0.15, 0.4, 0.85), Colour(0.5, 0.5, 0.5), Colour(0.85, 0.1, 0.1)
HALO = Colour(0.15, 0.4, 0.85, 0.2)
LINK = Colour(0.35, 0.35, 0.75)
AUTHORITY = Colour(0.55, 0.2, 0.7)
STEP, CERTIFICATE, CHORD, GAP = (
    Colour(0.1, 0.1, 0.1),
    Colour(0.1, 0.65, 0.3, 0.7),
    GROUND,
    Colour(0.0, 0.6, 0.8),
)


@dataclass(slots=True)
class Scene:
    """The state of the scene after the entries so far."""

    scenario: Scenario
    paths: dict[int, Path]
    """The strand's path in each epoch."""
    _order: tuple[int, ...] = ()
    _epoch: int = -1
    _forming: Forming = field(default_factory=Forming)
    _robots: Robots = field(default_factory=Robots)
    _ended: set[int] = field(default_factory=set)
    """The robots that are drawn as dead."""
    _places: dict[int, tuple[float, float]] = field(default_factory=dict)
    _granted: set[str] = field(default_factory=set)
    """The names of the authorities that are drawn."""
    _drawn_s: float = -math.inf
    _moved: bool = False

    def begin(self) -> list[Thing]:
        """The things that exist from the start."""
        ground = [outline(each, GROUND) for each in self.scenario.obstacles]
        things = [Thing("obstacles", tuple(ground))]
        if (bounds := self.scenario.bounds) is not None:
            x_m, y_m = (bounds.x_m_min, bounds.x_m_max), (bounds.y_m_min, bounds.y_m_max)
            ring = ((x_m[0], y_m[0]), (x_m[1], y_m[0]), (x_m[1], y_m[1]), (x_m[0], y_m[1]))
            things.append(Thing("bounds", (Stroke(ring, GROUND, closed=True),)))
        if (goal := self.scenario.goal) is not None:
            things.append(
                Thing("goal", (Disc(goal.at_m, goal.tolerance_m, GOAL), Label(goal.at_m, "goal", GOAL)))
            )
        return [*things, *(self._robot(each + 1, ROBOT) for each in range(self.scenario.fleet.robots))]

    def hear(self, source: str, entry: Entry) -> Iterator[Thing]:
        """The things that an entry changes."""
        if entry.t_s >= self._drawn_s + PERIOD_S:
            yield from self._moving(entry.t_s)
        yield from self._lives(source, entry)
        if (strand := self._forming.hear(entry)) is not None and strand.formed.epoch > self._epoch:
            self._order, self._epoch, self._moved = strand.formed.order, strand.formed.epoch, True
            yield from (Thing(name, ()) for name in sorted(self._granted))  # of the previous epoch: void
            self._granted.clear()
        match entry.record:
            case PoseSampled() as pose:
                self._places[pose.robot] = pose.x_m, pose.y_m
                self._moved = True
            case StepPlanned() as plan:
                yield self._step(plan)
            case AuthorityGranted() as grant if grant.epoch >= self._epoch:
                yield from self._authority(grant)
            case PromiseBroken(robot=robot) if robot_number(source) is None:
                yield self._robot(robot, BROKEN)
            case _:
                pass

    def _lives(self, source: str, entry: Entry) -> Iterator[Thing]:
        """A robot whose process has ended, or runs again."""
        told = len(self._robots.changes)
        self._robots.hear(source, entry)
        for change in self._robots.changes[told:]:
            if change.state.is_end != (change.robot in self._ended):
                (self._ended.add if change.state.is_end else self._ended.discard)(change.robot)
                yield self._robot(change.robot, DEAD if change.state.is_end else ROBOT)

    def _moving(self, t_s: float) -> Iterator[Thing]:
        self._drawn_s = t_s
        if self._moved:
            self._moved = False
            places = tuple(self._places[robot] for robot in self._order if robot in self._places)
            yield Thing("links", (Stroke(places, LINK),))
        if self.scenario.moving:
            at = self.scenario.movers.places_m(t_s).tolist()
            marks = [
                outline(each.outline, MOVING, tuple(place))
                for each, place in zip(self.scenario.moving, at, strict=True)
            ]
            yield Thing("moving", tuple(marks))

    def _robot(self, robot: int, colour: Colour) -> Thing:
        radius_m, halo_m = self.scenario.fleet.robot_radius_m, self.scenario.closest_m
        marks = (
            Disc((0.0, 0.0), halo_m, HALO),
            Disc((0.0, 0.0), radius_m or DOT_SHARE * halo_m, colour),
            Stroke(((0.0, 0.0), (halo_m, 0.0)), colour),
            Label((0.0, 0.0), str(robot), colour),
        )
        return Thing(f"robot/{robot}", marks, robot)

    def _authority(self, grant: AuthorityGranted) -> Iterator[Thing]:
        path = self.paths.get(grant.epoch)
        if path is not None:
            end = _place(path.at(grant.authority_m))
            mark = Disc(end, DOT_SHARE * self.scenario.closest_m, AUTHORITY)
            name = f"authority/{grant.to}"
            self._granted.add(name)
            yield Thing(name, (mark, Label(end, f"{grant.to}", AUTHORITY)))

    def _step(self, plan: StepPlanned) -> Thing:
        here, target = (plan.x_m, plan.y_m), _place(plan.target)
        marks: list[Stroke | Disc | Label] = [Stroke((here, target), STEP, width_px=3.0)]
        if plan.promised_clearance_m is not None:
            reach_m = self.scenario.fleet.robot_radius_m + plan.promised_clearance_m
            marks.append(capsule(here, target, reach_m, CERTIFICATE))
            marks.append(Label(target, f"step {plan.step}: {plan.promised_clearance_m:.3f} m", CERTIFICATE))
        marks += [Stroke((_place(each.tangent_1), _place(each.tangent_2)), CHORD) for each in plan.obstacles]
        if (gap := chosen_gap(plan)) is not None:
            marks.append(Stroke((_place(gap[0]), _place(gap[1])), GAP, width_px=4.0))
        return Thing("step", tuple(marks))


def readable_scenario(log: Log) -> tuple[Scenario | None, tuple[str, ...]]:
    """The scenario in a log's header; if this version cannot read it, a remark on what is missing."""
    try:
        return scenario_of(log), ()
    except UsageError as error:
        return None, (f"{error}: the export has no scene",)


def _place(point: Point) -> tuple[float, float]:
    return point.x_m, point.y_m
