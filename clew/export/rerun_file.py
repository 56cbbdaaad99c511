"""Rerun's RRD: the scene of a run, where robots were, what they saw, and its entries in words."""

import math
from pathlib import Path

import msgspec
import rerun as rr

from clew.export.drawing import Disc, Label, Stroke, Thing
from clew.export.exported import Exported
from clew.export.place import whole_file
from clew.export.scene import Scene, readable_scenario
from clew.log.log import Log
from clew.log.timeline import kind_of
from clew.story.in_order import survey
from protocol.timeline import Entry, PoseSampled, ScanServed

TIMELINE = "sim"
LEVELS = {"promise.broken": "ERROR", "robot.failed": "ERROR", "robot.died": "WARN", "fault.injected": "WARN"}
FLAT_M = 0.001  # half of a disc's height: Rerun draws solids


def export(log: Log, out: Path) -> Exported:
    """Write a log as one RRD file."""
    surveyed, count = survey(log), 0
    scenario, flaws = readable_scenario(log)
    with whole_file(out) as draft:
        recording = rr.RecordingStream("clew", recording_id=log.header.run)
        recording.save(draft)
        writing = _Writing(recording, None if scenario is None else Scene(scenario, surveyed.paths))
        writing.begin()
        for source, entry in surveyed.lines():
            writing.entry(source, entry)
            count += 1
        recording.flush()
        recording.disconnect()
    return Exported(count, (*log.flaws, *flaws))


class _Writing:
    """A recording that is being written."""

    def __init__(self, recording: rr.RecordingStream, scene: Scene | None) -> None:
        self._recording, self._scene = recording, scene
        self._range_m_max = math.inf if scene is None else scene.scenario.range_m_used

    def begin(self) -> None:
        """What is there before the first entry."""
        self._at(0.0)
        for thing in [] if self._scene is None else self._scene.begin():
            self._draw(thing)

    def entry(self, source: str, entry: Entry) -> None:
        """An entry, and all that shows it."""
        self._at(entry.t_s)
        for thing in [] if self._scene is None else self._scene.hear(source, entry):
            self._draw(thing)
        match entry.record:
            case PoseSampled() as pose:
                turn = rr.RotationAxisAngle(axis=(0.0, 0.0, 1.0), radians=pose.heading_rad)
                place = rr.Transform3D(translation=(pose.x_m, pose.y_m, 0.0), rotation=turn)
                self._recording.log(f"world/robot/{pose.robot}", place)
                return  # in words it would drown all others
            case ScanServed() as scan:
                self._scan(scan)
            case _:
                pass
        kind = kind_of(entry.record)
        text = f"{source} {msgspec.json.encode(entry.record).decode()}"
        self._recording.log(f"events/{kind}", rr.TextLog(text, level=LEVELS.get(kind, "INFO")))

    def _at(self, t_s: float) -> None:
        self._recording.set_time(TIMELINE, duration=t_s)

    def _scan(self, scan: ScanServed) -> None:
        hits = []
        for ray, range_m in enumerate(scan.ranges_m):
            if range_m < self._range_m_max:
                at_rad = scan.heading_rad - math.pi + math.tau * ray / len(scan.ranges_m)
                hits.append(
                    (scan.x_m + range_m * math.cos(at_rad), scan.y_m + range_m * math.sin(at_rad), 0.0)
                )
        self._recording.log(f"world/scan/{scan.robot}", rr.Points3D(hits, radii=rr.Radius.ui_points(2.0)))

    def _draw(self, thing: Thing) -> None:
        path = f"world/{thing.name}"
        strokes = [each for each in thing.marks if isinstance(each, Stroke)]
        discs = [each for each in thing.marks if isinstance(each, Disc)]
        labels = [each for each in thing.marks if isinstance(each, Label)]
        self._recording.log(f"{path}/lines", _lines(strokes))
        self._recording.log(f"{path}/discs", _discs(discs))
        self._recording.log(f"{path}/labels", _labels(labels))


def _lines(strokes: list[Stroke]) -> rr.LineStrips3D:
    strips = [[(*point, 0.0) for point in (*each.points, *each.points[: each.closed])] for each in strokes]
    colours = [_rgba(each) for each in strokes]
    return rr.LineStrips3D(
        strips, colors=colours, radii=[rr.Radius.ui_points(each.width_px / 2) for each in strokes]
    )


def _discs(discs: list[Disc]) -> rr.Ellipsoids3D:
    return rr.Ellipsoids3D(
        centers=[(*each.centre, 0.0) for each in discs],
        half_sizes=[(each.radius_m, each.radius_m, FLAT_M) for each in discs],
        colors=[_rgba(each) for each in discs],
        fill_mode=rr.components.FillMode.Solid,
    )


def _labels(labels: list[Label]) -> rr.Points3D:
    return rr.Points3D(
        [(*each.at, 0.0) for each in labels],
        labels=[each.text for each in labels],
        colors=[_rgba(each) for each in labels],
        radii=rr.Radius.ui_points(1.0),
    )


def _rgba(mark: Stroke | Disc | Label) -> tuple[float, float, float, float]:
    colour = mark.colour
    return colour.r, colour.g, colour.b, colour.a
