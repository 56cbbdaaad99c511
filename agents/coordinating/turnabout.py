"""The formation of a strand that turns round: the order and the path of the old one are reversed. Pure.

Rule 1: it exists only where all robots of the strand have reported places on the ending formation's path, in
        its order, and each only one; otherwise the view drafts a strand as any other view does.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from agents.liveness.reason import Turnabout
from protocol.fence import Epoch
from protocol.path import Path
from protocol.wire.view import Report


@dataclass(frozen=True, slots=True)
class Turning:
    """A strand that is to turn round."""

    turnabout: Turnabout
    """Where the new path begins and ends, in arc lengths of the old one."""
    ended: Epoch
    """The epoch of the strand."""
    robots: int
    """How many were in it."""
    path: Path
    """The old one, as the robot that leads knows it."""


Turned = tuple[tuple[int, ...], Path, dict[int, float]]
"""Order, path, and each robot's arc length along it."""


def turned_round(turning: Turning, reports: Mapping[int, Report]) -> Turned | None:
    """Rule 1."""
    at = sorted(
        (former.rank, robot, former.s_m)
        for robot, report in reports.items()
        for former in report.formers
        if former.epoch == turning.ended and not former.draft
    )
    order = tuple(robot for _, robot, _ in reversed(at))
    if [rank for rank, _, _ in at] != list(range(turning.robots)) or len({*order}) < len(order):
        return None
    end_m = turning.turnabout.end_m
    turned = turning.path.reversed(turning.turnabout.cut_m, end_m)
    places_m = {robot: min(max(end_m - s_m, 0.0), turned.end_m) for _, robot, s_m in at}
    return order, turned, places_m
