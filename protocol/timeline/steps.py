"""Entries of robots about their way: switching steps and checked segments."""

from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import Count, Length, Metres, Point, Radians
from protocol.mission import LawName
from protocol.timeline.base import Kind

SEEN_MAX = 250  # obstacles and gaps in an entry, which must fit into one message


class SeenObstacle(Struct, frozen=True, gc=False, kw_only=True):
    """An obstacle as seen in a scan: its tangent points, clockwise first, and the chord between them."""

    tangent_1: Point
    tangent_2: Point
    chord_m: Length


class SeenGap(Struct, frozen=True, gc=False, kw_only=True):
    """The opening between two obstacles that are neighbours anti-clockwise."""

    right: Annotated[Count, Meta(description="index of the obstacle on its right in `obstacles`")]
    left: Count
    width_m: Length
    delta_rad: Annotated[float, Meta(ge=0.0, le=6.3, description="angle seen from the switching position")]
    passable: bool


class StepPlanned(Kind, frozen=True, kw_only=True, tag="step.planned"):
    """The leader, or a robot that joins, has planned a step from one scan."""

    step: Count
    epoch: Annotated[Count, Meta(description="of the view in which the robot leads or joins")]
    law: LawName
    x_m: Metres
    y_m: Metres
    obstacles: Annotated[
        tuple[SeenObstacle, ...],
        Meta(max_length=SEEN_MAX, description=f"anti-clockwise; at most {SEEN_MAX} are recorded"),
    ]
    gaps: Annotated[tuple[SeenGap, ...], Meta(max_length=SEEN_MAX)]
    gap: Annotated[
        Count | None, Meta(description="index of the chosen gap in `gaps`; null: the step aims at no gap")
    ]
    heading_rad: Radians
    length_m: Length
    target: Point
    reach_m: Annotated[Length, Meta(description="arc length of the target along the strand's path")]
    promised_clearance_m: Annotated[Length | None, Meta(description="null: this law promises no clearance")]
    cost_to_go_m: Annotated[Length | None, Meta(description="from the target to the goal; null: no goal")]
    joins: Annotated[
        bool, Meta(description="the step of a robot that joins: `step` and `reach_m` are its own")
    ] = False


class StepAbandoned(Kind, frozen=True, kw_only=True, tag="step.abandoned"):
    """The leader has given up a step before its end: no scan let it drive on for 2 s, or it stood for 10 s.

    Mostly an obstacle has moved into its way, or near it. Lost scans have the same effect.
    """

    step: Count
    epoch: Count
    x_m: Metres
    y_m: Metres


class SegmentChecked(Kind, frozen=True, kw_only=True, tag="segment.checked"):
    """A following robot has checked its next segment of the path with its own scan."""

    target: Point
    clear: bool
    clearance_m: Annotated[
        Metres, Meta(description="of the swept hull to the nearest hit that is not a robot")
    ]
