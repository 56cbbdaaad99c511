"""How a strand forms through the places where its robots have lined up."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType

from agents.strand.strand import Places, Strand
from protocol.frames import Point, Pose
from protocol.mission import Mission
from protocol.path import Path, straightened
from protocol.timeline import StrandFormed


def lined_up(
    robot: int,
    order: tuple[int, ...],
    places: Mapping[int, Pose],
    mission: Mission,
    now_s: float,
    *,
    epoch: int = 1,
    legs: Mapping[int, Sequence[Point]] = MappingProxyType({}),
    driven: bool = False,
) -> Strand:
    """A robot's view of the strand when it has formed through the places of all robots.

    Args:
        robot: this one.
        order: the strand, leader first.
        places: where all stand.
        mission: the robot's.
        now_s: the time.
        epoch: the strand's.
        legs: corners of the ways to the robots ahead that are not straight, by robot.
        driven: whether the robot ahead has driven this one's leg.
    """
    rank = order.index(robot)
    points: list[Point] = []
    start_m: dict[int, float] = {}
    for each in reversed(order):
        points.append(Point(x_m=places[each].x_m, y_m=places[each].y_m))
        start_m[each] = Path(points).end_m
        points += legs.get(each, ()) if each != order[0] else ()
    at = Places(
        own_m=start_m[robot],
        ahead_m=start_m[order[max(rank - 1, 0)]],
        behind_m=start_m[order[rank + 1]] if rank + 1 < len(order) else 0.0,
    )
    # A straight queue is one segment: one check, no stops.
    path = Path(straightened(points))
    strand = Strand(robot, order, path, at, mission=mission, now_s=now_s, epoch=epoch)
    if driven:
        strand.own_leg_m = at.own_m
    return strand


def as_record(strand: Strand, *, sensed: bool, bent: bool) -> StrandFormed:
    """What the timeline tells of a strand that has formed.

    Args:
        strand: as this robot has it.
        sensed: whether it took a scan for the order.
        bent: whether to tell the corners of the path that there is.
    """
    return StrandFormed(
        epoch=strand.epoch,
        sensed=sensed,
        order=strand.order,
        path_length_m=strand.path.end_m,
        laid=tuple(Point(x_m=each.x_m, y_m=each.y_m) for each in strand.path) if bent else (),
    )
