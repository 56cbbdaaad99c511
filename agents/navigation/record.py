"""What the timeline tells of a switching step. Pure."""

from agents.navigation.certificate import promised_clearance_m
from agents.navigation.scan import View
from agents.navigation.step import Sight, Step
from protocol.arrays import Flags, Floats
from protocol.frames import METRES_MAX, Point
from protocol.mission import CERTIFIED, Mission
from protocol.timeline import SeenGap, SeenObstacle, StepPlanned
from protocol.timeline.steps import SEEN_MAX


def planned(
    step: Step,
    view: View,
    robots: Flags,
    mission: Mission,
    *,
    number: int,
    epoch: int,
    reach_m: float,
    sight: Sight | None = None,
) -> StepPlanned:
    """The record of a step.

    Args:
        step: the step.
        view: the scan that it was planned from.
        robots: the directions of the scan that hit robots.
        mission: the robot's.
        number: of the step.
        epoch: of the strand, or of the view in which the robot joins.
        reach_m: arc length of its end.
        sight: what the leader has seen; of a robot that joins none, since it does not go by gaps.
    """
    target = step.target(view.position)
    promised_m = promised_clearance_m(view, target, robots, mission) if mission.promises_clearance else None
    return StepPlanned(
        step=number,
        epoch=epoch,
        law=CERTIFIED if sight is None else mission.law,
        x_m=float(view.position[0]),
        y_m=float(view.position[1]),
        obstacles=() if sight is None else seen_obstacles(sight),
        gaps=() if sight is None else seen_gaps(sight),
        gap=step.gap if step.gap is not None and step.gap < SEEN_MAX else None,
        heading_rad=step.heading_rad,
        length_m=step.length_m,
        target=point(target),
        reach_m=reach_m,
        promised_clearance_m=promised_m,
        cost_to_go_m=None if step.cost_to_go_m is None else min(step.cost_to_go_m, METRES_MAX),
        joins=sight is None,
    )


def seen_obstacles(sight: Sight) -> tuple[SeenObstacle, ...]:
    """The obstacles that a leader has seen."""
    return tuple(
        SeenObstacle(
            tangent_1=point(obstacle.tangent_1), tangent_2=point(obstacle.tangent_2), chord_m=obstacle.chord_m
        )
        for obstacle in sight.obstacles[:SEEN_MAX]
    )


def seen_gaps(sight: Sight) -> tuple[SeenGap, ...]:
    """The gaps that a leader has seen."""
    passable = set(sight.passable_gaps)
    return tuple(
        SeenGap(
            right=gap.right,
            left=gap.left,
            width_m=gap.width_m,
            delta_rad=gap.delta_rad,
            passable=index in passable,
        )
        for index, gap in enumerate(sight.gaps[:SEEN_MAX])
    )


def point(place: Floats) -> Point:
    """A point with Python floats, as messages need it."""
    return Point(x_m=float(place[0]), y_m=float(place[1]))
