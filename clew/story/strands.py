"""The strand through time: its order and its path in each epoch, and where its leader stood.

Rule 1: a strand is there from when the first of its robots has recorded its place in it.
Rule 2: paths are made as S3 is judged: `world.judge.evidence`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import get_args

import numpy as np

from clew.story.batch import Position, Strand
from clew.story.columns import DECIMALS
from protocol.frames import Point
from protocol.keys import robot_number
from protocol.path import Path
from protocol.timeline import (
    Entry,
    MusterCalled,
    OrderAccepted,
    PoseSampled,
    StepAbandoned,
    StepFinished,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandReversed,
)
from world.geometry.clearance import distances
from world.geometry.shapes import Ground
from world.judge.evidence import Evidence
from world.judge.paths import Paths

Laying = StepPlanned | StepAbandoned | StrandFormed | StrandReversed | StrandDissolved | MusterCalled
"""What a path depends on, besides each robot's first order of an epoch."""
KINDS = frozenset({OrderAccepted, StepFinished, *get_args(Laying)})
"""What strands and positions are made of; the rest need not be heard."""


@dataclass(slots=True)
class Strands:
    """Orders and paths, as entries tell of them."""

    _evidence: Evidence = field(default_factory=Evidence)
    _formed: dict[int, StrandFormed] = field(default_factory=dict)
    """By epoch, as its first robot saw it."""
    _ordered: dict[int, int] = field(default_factory=dict)
    """The newest epoch in which each robot was ordered."""
    _changed: bool = False
    _told: dict[str, list[tuple[float, float]]] = field(default_factory=dict)

    def hear(self, source: str, entry: Entry) -> Strand | None:
        """Take an entry in; a strand, where it is the first of it."""
        match entry.record:
            case OrderAccepted(robot=robot, epoch=epoch) if self._ordered.get(robot) != epoch:
                self._ordered[robot] = epoch
                self._evidence.hear(source, entry)
                self._changed = True
            case StrandFormed(epoch=epoch) as formed:
                self._lay(source, entry)
                if self._formed.setdefault(epoch, formed) is formed:
                    return Strand(t_s=entry.t_s, epoch=epoch, order=formed.order)
            case record if isinstance(record, Laying):
                self._lay(source, entry)
            case _:
                pass
        return None

    def _lay(self, source: str, entry: Entry) -> None:
        if robot_number(source) is not None:
            self._evidence.hear(source, entry)
            self._changed = True

    def stand(self, t_s: float, pose: PoseSampled) -> None:
        """The newest sample of a body: where it stands that has not been ordered yet."""
        self._evidence.poses[pose.robot] = [(t_s, pose)]

    def paths(self) -> dict[str, list[tuple[float, float]]]:
        """The corners of each path, by epoch, that has changed since the last time."""
        if not self._changed:
            return {}
        self._changed = False
        now = {
            str(epoch): [(round(corner.x_m, DECIMALS), round(corner.y_m, DECIMALS)) for corner in path]
            for epoch, path in self.laid().items()
        }
        changed = {epoch: corners for epoch, corners in now.items() if self._told.get(epoch) != corners}
        self._told = now
        return changed

    def laid(self) -> dict[int, Path]:
        """The path of every epoch in which all robots have been seen."""
        paths = Paths(self._evidence)
        found = {epoch: paths.of(formed) for epoch, formed in self._formed.items()}
        return {epoch: path for epoch, path in found.items() if path is not None}


@dataclass(slots=True)
class Positions:
    """The rows of the step table, by the rule of `world.judge.tally`."""

    ground: Ground | None
    _begun: bool = False

    def hear(self, entry: Entry) -> Iterator[Position]:
        """The position that an entry of the world tells of, if any."""
        match entry.record:
            case OrderAccepted(step=1, robot=robot, x_m=x_m, y_m=y_m) if not self._begun:
                self._begun = True
                yield self._at(entry.t_s, robot, 0, Point(x_m=x_m, y_m=y_m), None)
            case StepFinished(robot=robot, step=step, x_m=x_m, y_m=y_m, clearance_m=clearance_m):
                yield self._at(entry.t_s, robot, step, Point(x_m=x_m, y_m=y_m), clearance_m)
            case _:
                pass

    def _at(self, t_s: float, robot: int, step: int, place: Point, clearance_m: float | None) -> Position:
        here_m = np.array([place.x_m, place.y_m])
        distances_m = [] if self.ground is None else distances(self.ground, here_m).tolist()
        return Position(
            t_s=t_s,
            robot=robot,
            step=step,
            x_m=place.x_m,
            y_m=place.y_m,
            clearance_m=clearance_m,
            distances_m=tuple(distances_m),
        )
