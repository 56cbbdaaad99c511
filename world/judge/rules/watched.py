"""S3: no body moves unwatched. So the samples are the whole motion, by which all else is judged.

Rule 1: the world samples a body that moves every `SAMPLED_S`. A longer way between two samples breaks S3:
        nobody knows how it went.
Rule 2: where the world says that a body was, when that took or finished an order or was scanned, lies on its
        way: between the sample before and the one after, or where it stands if none follows.
Rule 3: what stays off the way is one violation.
Rule 4: none follows when the log has its end, or entries from when it was due. Behind the last entry of a log
        that is cut off a body may have moved on.
"""

import math
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import get_args

from protocol.keys import WORLD
from protocol.timeline import (
    Entry,
    OrderAccepted,
    OrderFinished,
    PoseSampled,
    RunEnded,
    ScanServed,
    StepFinished,
)
from world.judge.rules.claims import ROUNDING_S
from world.judge.rules.evidence import ROUNDING_M, apart_m
from world.judge.rules.rule import Dated, breach_of

SAMPLED_S = 0.1  # simulated: odometry, as docs/run.md has it

Told = OrderAccepted | OrderFinished | ScanServed | StepFinished
"""What else says where a body is."""


Sample = tuple[float, PoseSampled]


@dataclass(slots=True)
class _Body:
    """What is known of one body."""

    _sampled: Sample | None = None
    """The newest sample."""
    _told: deque[tuple[float, Told]] = field(default_factory=deque)
    """What was told since, as far as the next sample may show that it was so."""
    _is_off: bool = False
    """Whether the newest place that was told is off its way."""

    def sample(self, t_s: float, pose: PoseSampled) -> Iterator[Dated]:
        """The body was here then: rule 1, and what was told before."""
        if self._sampled is not None:
            before_s, before = self._sampled
            moved_m = apart_m(before, pose)
            if moved_m > ROUNDING_M and t_s - before_s > SAMPLED_S + ROUNDING_S:
                why = f"moved, and was not sampled for {t_s - before_s:.2f} s"
                yield t_s, breach_of("S3", pose.robot, moved_m, 0.0, why)
        yield from self.compare(t_s, (t_s, pose))
        self._sampled = t_s, pose

    def tell(self, t_s: float, told: Told) -> None:
        """The world says that the body was here then."""
        self._told.append((t_s, told))

    def compare(self, until_s: float, after: Sample | None = None) -> Iterator[Dated]:
        """Rules 2 and 3, for what was told until then: by the sample after that; without one it stood."""
        while self._told and self._told[0][0] <= until_s:
            t_s, told = self._told.popleft()
            off_m = 0.0 if self._sampled is None else _off_m(t_s, told, self._sampled, after or self._sampled)
            was_off, self._is_off = self._is_off, off_m > ROUNDING_M
            if self._is_off and not was_off:
                why = f"is elsewhere than {type(told).__struct_config__.tag} says, by its samples"
                yield t_s, breach_of("S3", told.robot, off_m, 0.0, why)


class Watched:
    """Judges whether the world watched all bodies of a run."""

    kinds = frozenset[type]({PoseSampled, RunEnded, *get_args(Told)})

    def __init__(self) -> None:
        self._bodies: defaultdict[int, _Body] = defaultdict(_Body)
        self._watched_s = -math.inf
        """Until then all samples are there."""

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process what says where a body is, and the end of the log."""
        record, t_s = entry.record, entry.t_s
        if source != WORLD or not isinstance(record, PoseSampled | RunEnded | Told):
            return
        due_s = t_s - SAMPLED_S - ROUNDING_S
        self._watched_s = math.inf if isinstance(record, RunEnded) else max(self._watched_s, due_s)
        if isinstance(record, PoseSampled):
            yield from self._bodies[record.robot].sample(t_s, record)
        elif isinstance(record, Told):
            body = self._bodies[record.robot]
            yield from body.compare(due_s)
            body.tell(t_s, record)

    def close(self) -> Iterator[Dated]:
        """Rule 4."""
        for body in self._bodies.values():
            yield from body.compare(self._watched_s)


def _off_m(t_s: float, told: Told, before: Sample, after: Sample) -> float:
    """How far a place that was told is off the straight way between two samples."""
    (start_s, start), (end_s, end) = before, after
    share = min((t_s - start_s) / (end_s - start_s), 1.0) if end_s > start_s else 1.0
    x_m, y_m = start.x_m + share * (end.x_m - start.x_m), start.y_m + share * (end.y_m - start.y_m)
    return math.hypot(told.x_m - x_m, told.y_m - y_m)
