"""S4: the clearance that was promised for a step, held against the one that was kept. Pure; entry by entry.

Rule 1: along a step the hull keeps what `step.planned` promised, less mu0, from all obstacles that never
        move: from where the body took the order to where it ended it or was stopped. This holds for steps of
        the leader and of robots that join.
Rule 2: the clearance is measured from true poses, not taken from `step.finished`.
Rule 3: the plan may be recorded later than its step. Of several for one target the greatest promise counts.
        Steps of a robot that joins have no numbers in orders: their reach tells apart those for one target.
Rule 4: a step for which nothing was promised breaks that promise, too. Of a robot that died on its way or
        later, the plan may be missing. One that is there, and promises nothing, excuses nobody.
"""

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from protocol.fence import May
from protocol.frames import Point
from protocol.timeline import (
    Entry,
    FenceChanged,
    OrderAccepted,
    OrderFinished,
    PoseSampled,
    RobotDied,
    StepFinished,
    StepPlanned,
)
from world.geometry.clearance import clearance
from world.geometry.shapes import Ground
from world.judge.rules.evidence import ROUNDING_M
from world.judge.rules.rule import Dated, breach_of, broken

NOTHING = -math.inf
UNPROMISED = "drove a step for which no clearance was promised"
PROMISES_KEPT = 8  # of a robot: it plans a step when the one before is over

Key = tuple[int, int, float, Point]
"""Robot, epoch, step, and target; instead of the step, the reach of a step of a robot that joins."""


@dataclass(slots=True)
class _Way:
    """The way of a body in the step that it has in hand."""

    key: Key
    began_s: float
    places: list[tuple[float, float]]


class Clearances:
    """Judges the steps of one run, under a law that promises clearance."""

    def __init__(self, ground: Ground, *, radius_m: float, mu0_m: float) -> None:
        self._ground = ground
        self._radius_m = radius_m
        self._mu0_m = mu0_m
        self._may = May.NOBODY
        self._ways: dict[int, _Way] = {}
        self._promised_m: dict[int, dict[Key, float]] = defaultdict(dict)
        """The newest promises of each robot; `NOTHING` of a plan that promises none."""
        self._kept: dict[Key, tuple[float, float, float]] = {}
        """When steps began and ended whose plan has not come yet, and with which clearance."""
        self._died_s: dict[int, float] = {}

    def hear_world(self, entry: Entry) -> Iterator[Dated]:
        """Process an entry of the world."""
        match entry.record:
            case OrderAccepted(target=Point()) as order:
                yield from self._take(entry.t_s, order)
            case PoseSampled(robot=robot) as pose if robot in self._ways:
                self._ways[robot].places.append((pose.x_m, pose.y_m))
            case StepFinished(robot=robot) as end if robot in self._ways:
                self._ways[robot].places.append((end.x_m, end.y_m))
                yield from self._measure(entry.t_s, robot)
            case OrderFinished(robot=robot, step=0) as end if robot in self._ways:
                self._ways[robot].places.append((end.x_m, end.y_m))
                yield from self._measure(entry.t_s, robot)
            case RobotDied(robot=robot):
                self._died_s[robot] = entry.t_s
            case FenceChanged(may=may):
                self._may = may
                for robot in sorted(self._ways):
                    yield from self._measure(entry.t_s, robot)
            case _:
                pass  # no motion

    def hear_robot(self, robot: int, entry: Entry) -> Iterator[Dated]:
        """Process an entry of a robot."""
        match entry.record:
            case StepPlanned(promised_clearance_m=promised_m) as plan:
                key = robot, plan.epoch, plan.reach_m if plan.joins else plan.step, plan.target
                promised = self._promised_m[robot]
                least_m = NOTHING if promised_m is None else promised_m
                promised[key] = max(least_m, promised.get(key, NOTHING))
                if len(promised) > PROMISES_KEPT:
                    in_hand = self._ways.get(robot)
                    del promised[next(each for each in promised if in_hand is None or each != in_hand.key)]
                if key in self._kept:
                    _, t_s, kept_m = self._kept.pop(key)
                    yield from self._judge(t_s, robot, kept_m, promised[key])
            case _:
                pass  # no promise

    def close(self, t_s: float) -> Iterator[Dated]:
        """Judge the steps that bodies had in hand at the end."""
        for robot in sorted(self._ways):
            yield from self._measure(t_s, robot)

    def decide(self) -> Iterator[Dated]:
        """The run is over: judge the steps whose plan has never come."""
        for (robot, *_), (began_s, ended_s, _) in self._kept.items():
            if self._died_s.get(robot, -math.inf) < began_s:
                yield ended_s, broken("S4", robot, UNPROMISED)

    def _take(self, t_s: float, order: OrderAccepted) -> Iterator[Dated]:
        """A body has taken an order to drive: a new step, or the one that it had before it stood."""
        joins = order.step == 0 and self._may is May.ONE
        assert order.target is not None, "it is to drive"
        key = order.robot, order.epoch, order.reach_m if joins else order.step, order.target
        way = self._ways.get(order.robot)
        if way is None or way.key != key:
            if way is not None:
                way.places.append((order.x_m, order.y_m))
            yield from self._measure(t_s, order.robot)
            if order.step > 0 or joins:
                self._ways[order.robot] = _Way(key, t_s, [(order.x_m, order.y_m)])

    def _measure(self, t_s: float, robot: int) -> Iterator[Dated]:
        """The step in hand is over."""
        way = self._ways.pop(robot, None)
        if way is None:
            return
        places_m = np.array(way.places)
        starts_m = np.concatenate((places_m[:1], places_m[:-1]))
        kept_m = float(clearance(self._ground, starts_m, places_m).min()) - self._radius_m
        promised_m = self._promised_m[robot].get(way.key)
        if promised_m is None:
            before = self._kept.get(way.key, (way.began_s, t_s, kept_m))
            self._kept[way.key] = before[0], t_s, min(kept_m, before[2])
        else:
            yield from self._judge(t_s, robot, kept_m, promised_m)

    def _judge(self, t_s: float, robot: int, kept_m: float, promised_m: float) -> Iterator[Dated]:
        required_m = promised_m - self._mu0_m
        if promised_m == NOTHING:
            yield t_s, broken("S4", robot, UNPROMISED)
        elif kept_m < required_m - ROUNDING_M:
            yield (
                t_s,
                breach_of("S4", robot, kept_m, required_m, "kept less clearance than promised for the step"),
            )
