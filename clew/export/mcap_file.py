"""MCAP: a log in Foxglove's types, for tools that show and replay runs, and every entry as JSON.

Rule 1: the header and every entry are one message each on `/events/KIND`, as the recorder writes it. Fields
        that this program does not know, from a newer version or from manual edits, are left out.
Rule 2: messages are ordered by time. The drawing of an entry comes before the entry itself.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import foxglove
import msgspec
from foxglove import channels

from clew.export import foxglove_types as types
from clew.export.drawing import Thing
from clew.export.exported import Exported
from clew.export.json_schema import schema_of
from clew.export.place import whole_file
from clew.export.scene import Scene, readable_scenario
from clew.export.times import at_ns, started_ns
from clew.log.log import Log
from clew.story.in_order import survey
from protocol.timeline import Entry, PoseSampled, ScanServed, kind_of
from protocol.timeline.base import Kind
from world.record.recorder import Header, line

OURS = "clew"
"""The name of our metadata, which stand first in the file."""
MARK = len(OURS).to_bytes(4, "little") + OURS.encode()
"""The same as it is written."""
FOREIGN = "FoxgloveError: "  # its writer's errors have no type of their own, but this beginning


def export(log: Log, out: Path) -> Exported:
    """Write a log as one MCAP file."""
    surveyed, count = survey(log), 0
    scenario, flaws = readable_scenario(log)
    start_ns = started_ns(log.header)
    with whole_file(out, MARK) as draft, _opened(draft, log.header) as context:
        writing = _Writing(context, start_ns, None if scenario is None else Scene(scenario, surveyed.paths))
        writing.begin(log.header)
        for source, entry in surveyed.lines():
            writing.entry(source, entry)
            count += 1
    return Exported(count, (*log.flaws, *flaws))


@contextmanager
def _opened(path: Path, header: Header) -> Iterator[foxglove.Context]:
    """The context whose channels are written to the file.

    Raises:
        OSError: the file cannot be written, for example on a full disk.
    """
    context = foxglove.Context()
    said = {name: getattr(header, name) for name in ("schema", "run", "seed", "scenario_hash", "started_at")}
    try:
        with foxglove.open_mcap(path, context=context) as writer:
            writer.write_metadata(OURS, {name: str(value) for name, value in said.items()})
            yield context
    except RuntimeError as error:
        if not str(error).startswith(FOREIGN):
            raise
        raise OSError(str(error).removeprefix(FOREIGN)) from error


class _Writing:
    """The channels of a file that is being written, each made on first use."""

    def __init__(self, context: foxglove.Context, start_ns: int, scene: Scene | None) -> None:
        self._context, self._start_ns, self._scene = context, start_ns, scene
        self._range_m_max = math.inf if scene is None else scene.scenario.range_m_used
        self._scenes = channels.SceneUpdateChannel("/scene", context=context)
        self._frames = channels.FrameTransformsChannel("/tf", context=context)
        self._words = channels.LogChannel("/log", context=context)
        self._poses: dict[int, channels.PoseInFrameChannel] = {}
        self._scans: dict[int, channels.LaserScanChannel] = {}
        self._events: dict[str, foxglove.Channel] = {}

    def begin(self, header: Header) -> None:
        """Write the messages before the first entry."""
        self._draw([] if self._scene is None else self._scene.begin(), self._start_ns)
        self._event("run.started", Header, msgspec.json.encode(header), self._start_ns)

    def entry(self, source: str, entry: Entry) -> None:
        """Write an entry and everything that shows it."""
        time_ns = at_ns(self._start_ns, entry.t_s)
        self._draw([] if self._scene is None else [*self._scene.hear(source, entry)], time_ns)
        match entry.record:
            case PoseSampled() as pose:
                self._pose(pose, time_ns)
            case ScanServed(ranges_m=ranges_m) as scan if ranges_m:
                self._scan(scan, time_ns)
            case _:
                pass
        text, kind = line(source, entry)[:-1], kind_of(entry.record)
        if not isinstance(entry.record, PoseSampled):  # poses would drown all other messages
            self._words.log(types.said(source, kind, entry.record, time_ns), log_time=time_ns)
        self._event(kind, type(entry.record), text, time_ns)

    def _draw(self, things: list[Thing], time_ns: int) -> None:
        if things:
            self._scenes.log(types.scene(things, time_ns), log_time=time_ns)

    def _pose(self, pose: PoseSampled, time_ns: int) -> None:
        channel = self._poses.get(pose.robot)
        if channel is None:
            channel = channels.PoseInFrameChannel(f"/robot/{pose.robot}/pose", context=self._context)
            self._poses[pose.robot] = channel
        channel.log(types.placed(pose, time_ns), log_time=time_ns)
        self._frames.log(types.transform(pose, time_ns), log_time=time_ns)

    def _scan(self, scan: ScanServed, time_ns: int) -> None:
        channel = self._scans.get(scan.robot)
        if channel is None:
            channel = channels.LaserScanChannel(f"/robot/{scan.robot}/scan", context=self._context)
            self._scans[scan.robot] = channel
        channel.log(types.scan(scan, self._range_m_max, time_ns), log_time=time_ns)

    def _event(self, kind: str, record: type[Kind] | type[Header], text: bytes, time_ns: int) -> None:
        """Rule 1: write an entry as JSON."""
        channel = self._events.get(kind)
        if channel is None:
            data = msgspec.json.encode(schema_of(record))
            schema = foxglove.Schema(name=f"clew.{kind}", encoding="jsonschema", data=data)
            channel = foxglove.Channel(
                f"/events/{kind}", schema=schema, message_encoding="json", context=self._context
            )
            self._events[kind] = channel
        channel.log(text, log_time=time_ns)
