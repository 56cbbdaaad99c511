"""S3: no body moves unwatched. So the samples are the whole motion, by which all else is judged.

Rule 1: the world samples a body that moves every `SAMPLED_S`. A longer way between two samples breaks S3:
        nobody knows how it went.
Rule 2: where the world says that a body was, when that took or finished an order or was scanned, lies on its
        way: between the sample before and the one after, or where it stands if none follows.
Rule 3: what stays off the way is one violation.
"""

import math
from collections import defaultdict, deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import get_args

from protocol.frames import Point
from protocol.keys import WORLD
from protocol.timeline import Entry, OrderAccepted, OrderFinished, PoseSampled, ScanServed, StepFinished
from world.judge.rules.claims import ROUNDING_S
from world.judge.rules.evidence import ROUNDING_M, apart_m
from world.judge.rules.rule import Dated, breach_of

SAMPLED_S = 0.1  # simulated: odometry, as docs/run.md has it

Told = OrderAccepted | OrderFinished | ScanServed | StepFinished
"""What else says where a body is."""


@dataclass(slots=True)
class _Body:
    """What is known of one body."""

    sampled: tuple[float, PoseSampled] | None = None
    """The newest sample."""
    told: deque[tuple[float, Told]] = field(default_factory=deque)
    """What was told since, as far as the next sample may show that it was so."""
    is_off: bool = False
    """Whether the newest place that was told is off its way."""

    def off_m(self, t_s: float, told: Told, until: tuple[float, PoseSampled] | None) -> float:
        """How far a place is off the way from the newest sample to the next one; without that, it stood."""
        assert self.sampled is not None, "else there is no way yet"
        (start_s, start), (end_s, end) = self.sampled, until or self.sampled
        share = min((t_s - start_s) / (end_s - start_s), 1.0) if end_s > start_s else 1.0
        there = Point(
            x_m=start.x_m + share * (end.x_m - start.x_m), y_m=start.y_m + share * (end.y_m - start.y_m)
        )
        return apart_m(there, Point(x_m=told.x_m, y_m=told.y_m))


class Watched:
    """Judges whether the world watched all bodies of a run."""

    kinds = frozenset[type]({PoseSampled, *get_args(Told)})

    def __init__(self) -> None:
        self._bodies: defaultdict[int, _Body] = defaultdict(_Body)

    def hear(self, source: str, entry: Entry) -> Iterator[Dated]:
        """Process what says where a body is."""
        record, t_s = entry.record, entry.t_s
        if source != WORLD or not isinstance(record, PoseSampled | Told):
            return
        body = self._bodies[record.robot]
        if isinstance(record, PoseSampled):
            yield from _unwatched(body, t_s, record)
            yield from _astray(body, t_s, (t_s, record))
            body.sampled = t_s, record
        else:
            yield from _astray(body, t_s - SAMPLED_S - ROUNDING_S, None)
            body.told.append((t_s, record))

    def close(self) -> Iterator[Dated]:
        """No sample follows."""
        for body in self._bodies.values():
            yield from _astray(body, math.inf, None)


def _unwatched(body: _Body, t_s: float, pose: PoseSampled) -> Iterator[Dated]:
    """Rule 1."""
    if body.sampled is None:
        return
    before_s, before = body.sampled
    moved_m = apart_m(before, pose)
    if moved_m > ROUNDING_M and t_s - before_s > SAMPLED_S + ROUNDING_S:
        why = f"moved, and was not sampled for {t_s - before_s:.2f} s"
        yield t_s, breach_of("S3", pose.robot, moved_m, 0.0, why)


def _astray(body: _Body, until_s: float, sampled: tuple[float, PoseSampled] | None) -> Iterator[Dated]:
    """Rules 2 and 3, for all that was told until then: by the next sample, or the body stood."""
    while body.told and body.told[0][0] <= until_s:
        t_s, told = body.told.popleft()
        if body.sampled is None:
            continue
        off_m, was_off = body.off_m(t_s, told, sampled), body.is_off
        body.is_off = off_m > ROUNDING_M
        if body.is_off and not was_off:
            said = type(told).__struct_config__.tag
            why = f"is elsewhere than {said} says, by its samples"
            yield t_s, breach_of("S3", told.robot, off_m, 0.0, why)
