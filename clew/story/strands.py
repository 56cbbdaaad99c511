"""The strand through time: its order and its path in each epoch. Pure.

Rule 1: a strand is there from when the first of its robots has recorded its place in it.
Rule 2: paths are made as S3 is judged: `world.judge.evidence`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import get_args

from protocol.keys import robot_number
from protocol.path import Path
from protocol.timeline import (
    Entry,
    MusterCalled,
    OrderAccepted,
    PoseSampled,
    StepAbandoned,
    StepPlanned,
    StrandDissolved,
    StrandFormed,
    StrandReversed,
)
from world.judge.evidence import Evidence
from world.judge.paths import Paths

LAYING = frozenset(
    get_args(StepPlanned | StepAbandoned | StrandFormed | StrandReversed | StrandDissolved | MusterCalled)
)
"""What a path depends on, besides each robot's first order of an epoch."""
KINDS = LAYING | {OrderAccepted}


@dataclass(frozen=True, slots=True)
class Strand:
    """The order of the strand from a time on, leader first."""

    t_s: float
    formed: StrandFormed
    """As its first robot saw it."""


@dataclass(slots=True)
class Strands:
    """Orders and paths, as entries tell of them."""

    formed: dict[int, Strand] = field(default_factory=dict)
    """By epoch, in the order in which they were heard of."""
    laid_count: int = 0
    """How many entries have been heard on which a path depends."""
    _evidence: Evidence = field(default_factory=Evidence)
    _ordered: dict[int, int] = field(default_factory=dict)
    """The newest epoch in which each robot was ordered."""

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        record = entry.record
        if isinstance(record, OrderAccepted):
            if self._ordered.get(record.robot) == record.epoch:
                return
            self._ordered[record.robot] = record.epoch
        elif type(record) not in LAYING or robot_number(source) is None:
            return
        self._evidence.hear(source, entry)
        self.laid_count += 1
        if isinstance(record, StrandFormed) and record.epoch not in self.formed:
            self.formed[record.epoch] = Strand(entry.t_s, record)

    def paths(self, poses: Mapping[int, tuple[float, PoseSampled]]) -> dict[int, Path]:
        """The path of every epoch in which all robots have been seen; `poses`: the newest of each."""
        for robot, seen in poses.items():
            self._evidence.poses[robot] = [seen]  # where a body stands that has not been ordered yet
        paths = Paths(self._evidence)
        found = {epoch: paths.of(strand.formed) for epoch, strand in self.formed.items()}
        return {epoch: path for epoch, path in found.items() if path is not None}
