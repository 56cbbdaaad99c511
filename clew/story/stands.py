"""The switching positions of a run: where its steps began and ended, by the log's numbers of steps. Pure.

Rule 1: where step k began is k. Where a step ended and the next did not begin, or there was none, is "k end".
Rule 2: a step ends where it was finished or abandoned; one that was broken off, for another robot came to
        lead, where the body of its own was when the next began.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from protocol.frames import Point
from protocol.keys import WORLD, robot_number
from protocol.timeline import OrderAccepted, StepAbandoned, StepFinished
from world.judge.evidence import Evidence
from world.record.lines import Line

SAME_M = 1e-3  # a body that turns on the spot stays there; no step is so short


@dataclass(frozen=True, slots=True)
class Stand:
    """The leader at a switching position [world frame]."""

    t_s: float
    robot: int
    place: Point
    step: int
    ends: bool

    @property
    def name(self) -> str:
        """Rule 1."""
        return f"{self.step} end" if self.ends else str(self.step)


def stands_of(lines: Iterable[Line], leaders: Mapping[int, int], seen: Evidence) -> tuple[Stand, ...]:
    """The switching positions, by the log's entries, who led in which epoch, and where bodies were seen."""
    stands: list[Stand] = []
    under_way: Stand | None = None
    for stand in _told(lines, leaders):
        if under_way is not None and not stand.ends and stand.robot != under_way.robot:
            stands.append(_broken_off(under_way, stand.t_s, seen))
        under_way = None if stand.ends else stand
        if not stand.ends and stands and stands[-1].ends and _are_same(stands[-1], stand):
            stands[-1] = replace(stands[-1], step=stand.step, robot=stand.robot, ends=False)
        else:
            stands.append(stand)
    return tuple(stands)


def _told(lines: Iterable[Line], leaders: Mapping[int, int]) -> Iterator[Stand]:
    """Each step of a leader where it began, and where it was finished or abandoned."""
    begun: set[tuple[int, int]] = set()
    for source, entry in lines:
        match entry.record:
            case OrderAccepted(robot=robot, epoch=epoch, step=step) as order if (
                step > 0 and leaders.get(epoch) == robot and (epoch, step) not in begun
            ):
                begun.add((epoch, step))
                yield Stand(entry.t_s, robot, Point(x_m=order.x_m, y_m=order.y_m), step, ends=False)
            case StepFinished(robot=robot, step=step) as ended if source == WORLD:
                yield Stand(entry.t_s, robot, Point(x_m=ended.x_m, y_m=ended.y_m), step, ends=True)
            case StepAbandoned(step=step) as ended if (speaker := robot_number(source)) is not None:
                yield Stand(entry.t_s, speaker, Point(x_m=ended.x_m, y_m=ended.y_m), step, ends=True)
            case _:
                pass  # nothing of a step


def _broken_off(begun: Stand, t_s: float, seen: Evidence) -> Stand:
    """Where a step ended of which the log says no end."""
    poses = [pose for at_s, pose in seen.poses[begun.robot] if at_s <= t_s]
    place = Point(x_m=poses[-1].x_m, y_m=poses[-1].y_m) if poses else begun.place
    return replace(begun, t_s=t_s, place=place, ends=True)


def _are_same(one: Stand, other: Stand) -> bool:
    return math.hypot(one.place.x_m - other.place.x_m, one.place.y_m - other.place.y_m) <= SAME_M
