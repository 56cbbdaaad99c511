"""Entries and things to draw in Foxglove's types."""

import math
from collections.abc import Sequence

from foxglove import messages as fg
from foxglove.messages import LinePrimitiveLineType, LogLevel, Timestamp

from clew.export.drawing import Colour, Disc, Label, Stroke, Thing
from protocol.timeline import PoseSampled, Record, ScanServed
from protocol.timeline.sentences import sentence

WORLD_FRAME = "world"
LEVELS = dict.fromkeys(
    ("law.failed", "promise.broken", "robot.failed", "route.lost"), LogLevel.Error
) | dict.fromkeys(
    (
        "fault.injected",
        "law.stalled",
        "link.broken",
        "link.silent",
        "message.refused",
        "order.refused",
        "robot.died",
        "router.lost",
        "step.abandoned",
    ),
    LogLevel.Warning,
)
"""The levels of kinds that are more than information."""
FLAT_M = 0.001  # a disc's height: Foxglove draws solids
WORD_PX = 14.0


def frame_of(robot: int) -> str:
    """The name of the frame that moves with a robot: x ahead, y to its left."""
    return f"robot/{robot}"


def stamp(time_ns: int) -> Timestamp:
    """A time in Foxglove's type."""
    return Timestamp(*divmod(time_ns, 10**9))


def pose(place: PoseSampled | ScanServed) -> fg.Pose:
    """The position and orientation of a body."""
    return fg.Pose(
        position=fg.Vector3(x=place.x_m, y=place.y_m, z=0.0),
        orientation=_turned(place.heading_rad),
    )


def placed(place: PoseSampled, time_ns: int) -> fg.PoseInFrame:
    """The same as a separate message."""
    return fg.PoseInFrame(timestamp=stamp(time_ns), frame_id=WORLD_FRAME, pose=pose(place))


def said(source: str, kind: str, record: Record, time_ns: int) -> fg.Log:
    """An entry as a log message."""
    level = LEVELS.get(kind, LogLevel.Info)
    message = f"{kind}: {sentence(source, record)}"
    return fg.Log(timestamp=stamp(time_ns), level=level, name=source, message=message)


def transform(place: PoseSampled, time_ns: int) -> fg.FrameTransforms:
    """The transform of a robot's frame in the world frame."""
    return fg.FrameTransforms(
        transforms=[
            fg.FrameTransform(
                timestamp=stamp(time_ns),
                parent_frame_id=WORLD_FRAME,
                child_frame_id=frame_of(place.robot),
                translation=fg.Vector3(x=place.x_m, y=place.y_m, z=0.0),
                rotation=_turned(place.heading_rad),
            )
        ]
    )


def scan(served: ScanServed, range_m_max: float, time_ns: int) -> fg.LaserScan:
    """The scan of a body's sensor; a ray without a hit is infinite."""
    step_rad = math.tau / len(served.ranges_m)
    return fg.LaserScan(
        timestamp=stamp(time_ns),
        frame_id=WORLD_FRAME,
        pose=pose(served),
        start_angle=-math.pi,
        end_angle=math.pi - step_rad,
        ranges=[range_m if range_m < range_m_max else math.inf for range_m in served.ranges_m],
    )


def scene(things: Sequence[Thing], time_ns: int) -> fg.SceneUpdate:
    """A scene update: each thing replaces the earlier one with its name."""
    return fg.SceneUpdate(entities=[_entity(each, time_ns) for each in things])


def _entity(thing: Thing, time_ns: int) -> fg.SceneEntity:
    marks = thing.marks
    return fg.SceneEntity(
        timestamp=stamp(time_ns),
        frame_id=WORLD_FRAME if thing.robot is None else frame_of(thing.robot),
        id=thing.name,
        frame_locked=thing.robot is not None,
        lines=[_line(each) for each in marks if isinstance(each, Stroke)],
        cylinders=[_disc(each) for each in marks if isinstance(each, Disc)],
        texts=[_text(each) for each in marks if isinstance(each, Label)],
    )


def _line(stroke: Stroke) -> fg.LinePrimitive:
    return fg.LinePrimitive(
        type=LinePrimitiveLineType.LineLoop if stroke.closed else LinePrimitiveLineType.LineStrip,
        pose=_at((0.0, 0.0)),
        thickness=stroke.width_px,
        scale_invariant=True,
        points=[fg.Point3(x=x_m, y=y_m, z=0.0) for x_m, y_m in stroke.points],
        color=_colour(stroke.colour),
    )


def _disc(disc: Disc) -> fg.CylinderPrimitive:
    return fg.CylinderPrimitive(
        pose=_at(disc.centre),
        size=fg.Vector3(x=2.0 * disc.radius_m, y=2.0 * disc.radius_m, z=FLAT_M),
        bottom_scale=1.0,
        top_scale=1.0,
        color=_colour(disc.colour),
    )


def _text(label: Label) -> fg.TextPrimitive:
    return fg.TextPrimitive(
        pose=_at(label.at),
        billboard=True,
        font_size=WORD_PX,
        scale_invariant=True,
        color=_colour(label.colour),
        text=label.text,
    )


def _at(place: tuple[float, float]) -> fg.Pose:
    return fg.Pose(position=fg.Vector3(x=place[0], y=place[1], z=0.0), orientation=_turned(0.0))


def _turned(heading_rad: float) -> fg.Quaternion:
    return fg.Quaternion(x=0.0, y=0.0, z=math.sin(heading_rad / 2), w=math.cos(heading_rad / 2))


def _colour(colour: Colour) -> fg.Color:
    return fg.Color(r=colour.r, g=colour.g, b=colour.b, a=colour.a)
