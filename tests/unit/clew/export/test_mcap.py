"""MCAP, read back with `mcap`'s own reader and Foxglove's schemas, as `mcap doctor` does."""

import math
from collections import Counter
from collections.abc import Iterator
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any

import msgspec
import pytest
from mcap.reader import SeekingReader, make_reader
from mcap.records import Channel, ChunkIndex, Message, Schema, Statistics
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory

from clew.export import mcap_file
from clew.export.times import started_ns
from clew.log.log import Log
from protocol.timeline import (
    KINDS,
    PoseSampled,
    Record,
    RobotHeld,
    RobotStarted,
    RunEnded,
    ScanServed,
    kind_of,
)
from tests.support.campaigns import clew
from tests.support.logs.logs import HEADER, numbered, recorded
from tests.support.runs import Runs
from world.record.lines import Line
from world.record.recorder import line


@pytest.fixture(scope="module")
def run(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = runs.copy(tmp_path_factory.mktemp("lively") / "run", "grove", faults="leader-killed")
    said = clew("log", "export", folder, "--to", "mcap")
    assert said.stdout.strip() == str(folder / "events.mcap")
    return folder


@cache
def messages(path: Path) -> list[tuple[Schema | None, Channel, Message, Any]]:
    """All messages in file order, decoded; checks every checksum."""
    reader = SeekingReader(
        BytesIO(path.read_bytes()), validate_crcs=True, decoder_factories=[DecoderFactory()]
    )
    raw = [
        (schema, channel, message) for schema, channel, message in reader.iter_messages(log_time_order=False)
    ]
    return [(schema, channel, message, decoded(schema, message)) for schema, channel, message in raw]


def decoded(schema: Schema | None, message: Message) -> Any:  # noqa: ANN401 - of any schema
    decoder = DecoderFactory().decoder_for("protobuf", schema)
    return msgspec.json.decode(message.data) if decoder is None or schema is None else decoder(message.data)


def on(path: Path, topic: str) -> list[Any]:
    return [said for _, channel, _, said in messages(path) if channel.topic == topic]


def entries(run: Path) -> list[Line]:
    return list(Log(run).lines)


def test_the_file_is_complete_by_its_checksums_and_summary(run: Path) -> None:
    content = (run / "events.mcap").read_bytes()
    records = list(StreamReader(BytesIO(content), validate_crcs=True).records)
    summary = make_reader(BytesIO(content)).get_summary()
    assert summary is not None
    counts = Counter(channel.topic for _, channel, _, _ in messages(run / "events.mcap"))
    statistics = summary.statistics
    assert isinstance(statistics, Statistics)
    assert statistics.message_count == counts.total()
    assert statistics.chunk_count == len(summary.chunk_indexes) > 0
    assert sum(isinstance(record, ChunkIndex) for record in records) == statistics.chunk_count
    told = {summary.channels[key].topic: count for key, count in statistics.channel_message_counts.items()}
    assert told == counts
    assert all(summary.schemas[channel.schema_id].data for channel in summary.channels.values())


def test_messages_are_ordered_by_time(run: Path) -> None:
    times_ns = [message.log_time for _, _, message, _ in messages(run / "events.mcap")]
    assert times_ns == sorted(times_ns)
    assert [message.publish_time for _, _, message, _ in messages(run / "events.mcap")] == times_ns


def test_every_entry_is_a_message_byte_for_byte(run: Path) -> None:
    found: Counter[tuple[str, int, bytes]] = Counter()
    for _, channel, message, _ in messages(run / "events.mcap"):
        if channel.topic.startswith("/events/"):
            found[channel.topic, message.log_time, message.data] += 1
    first, *texts = (run / "events.jsonl").read_bytes().splitlines()
    lines = entries(run)
    assert [line(*each)[:-1] for each in lines] == texts
    wanted = Counter(
        (f"/events/{kind_of(entry.record)}", round(entry.t_s * 1e9), text)
        for (_, entry), text in zip(lines, texts, strict=True)
    )
    assert found == wanted + Counter([("/events/run.started", 0, first)])


def test_schemas_of_events_name_their_fields_and_have_no_references(run: Path) -> None:
    for schema, channel, _, said in messages(run / "events.mcap"):
        if channel.topic.startswith("/events/"):
            assert schema is not None
            assert schema.encoding == "jsonschema"
            read = msgspec.json.decode(schema.data)
            assert read["type"] == "object"
            assert b"$ref" not in schema.data
            assert set(read["required"]) <= set(said) <= set(read["properties"])


def test_robots_are_drawn_at_their_poses(run: Path) -> None:
    poses = [entry.record for _, entry in entries(run) if isinstance(entry.record, PoseSampled)]
    frames = [update.transforms[0] for update in on(run / "events.mcap", "/tf")]
    assert len(frames) == len(poses)
    for pose, frame in zip(poses, frames, strict=True):
        assert (frame.parent_frame_id, frame.child_frame_id) == ("world", f"robot/{pose.robot}")
        assert (frame.translation.x, frame.translation.y) == (pose.x_m, pose.y_m)
        heading_rad = 2.0 * math.atan2(frame.rotation.z, frame.rotation.w)
        assert heading_rad == pytest.approx(pose.heading_rad)
    for robot in range(1, 6):
        own = [pose for pose in poses if pose.robot == robot]
        said = on(run / "events.mcap", f"/robot/{robot}/pose")
        assert [(each.pose.position.x, each.frame_id) for each in said] == [
            (pose.x_m, "world") for pose in own
        ]


def test_scans_have_the_bodys_pose_and_infinite_rays_without_a_hit(run: Path) -> None:
    scans = [entry.record for _, entry in entries(run) if isinstance(entry.record, ScanServed)]
    for robot in range(1, 6):
        own = [scan for scan in scans if scan.robot == robot]
        for scan, said in zip(own, on(run / "events.mcap", f"/robot/{robot}/scan"), strict=True):
            assert said.start_angle == pytest.approx(-math.pi)
            assert said.end_angle == pytest.approx(math.pi - math.tau / len(scan.ranges_m))
            assert (said.pose.position.x, said.pose.position.y) == (scan.x_m, scan.y_m)
            hits = [(told, range_m) for told, range_m in zip(said.ranges, scan.ranges_m, strict=True)]
            assert all(told in (range_m, math.inf) for told, range_m in hits)
            assert {math.isinf(told) for told, _ in hits} == {True, False}


def test_log_messages_omit_poses_and_have_a_higher_level_for_deaths(run: Path) -> None:
    said = on(run / "events.mcap", "/log")
    assert len(said) == sum(not isinstance(entry.record, PoseSampled) for _, entry in entries(run))
    death = next(each for each in said if each.message.startswith("robot.died"))
    assert (death.name, death.level) == ("world", 3)
    assert death.message.startswith("robot.died: r1 has died, silent since t=")


def things(path: Path) -> Iterator[Any]:
    for update in on(path, "/scene"):
        yield from update.entities


def test_the_scene_has_ground_robots_strand_and_steps(run: Path) -> None:
    seen = Counter(entity.id for entity in things(run / "events.mcap"))
    kinds = Counter(kind_of(entry.record) for _, entry in entries(run))
    assert seen["obstacles"] == seen["bounds"] == seen["goal"] == 1
    assert seen["robot/1"] == 2  # alive, then dead
    assert seen["robot/2"] == 1
    assert seen["step"] == kinds["step.planned"]
    assert seen["links"] > 100
    assert {"authority/2", "authority/5"} <= set(seen)


def test_moving_obstacles_move(runs: Runs, tmp_path: Path) -> None:
    clew("log", "export", runs.of("pedestrian"), "--to", "mcap", "--out", tmp_path / "new" / "run.mcap")
    places = [
        entity.lines[0].points[0] for entity in things(tmp_path / "new" / "run.mcap") if entity.id == "moving"
    ]
    assert len({(place.x, place.y) for place in places}) > 10


def test_times_begin_at_the_start_of_the_run_and_late_entries_are_sorted_in(tmp_path: Path) -> None:
    late: tuple[tuple[str, Record], ...] = (
        ("world", PoseSampled(robot=1, x_m=0.0, y_m=0.0, heading_rad=0.0)),
        ("world", RunEnded(reason="done")),
        ("r1", RobotStarted(pid=1)),
        ("r1", RobotHeld(behind_m=1.0)),
    )
    lines = [(source, msgspec.structs.replace(entry, t_s=3.0 - entry.n)) for source, entry in numbered(late)]
    folder = recorded(tmp_path / "run", lines)
    mcap_file.export(Log(folder), folder / "late.mcap")
    start_ns = started_ns(HEADER)
    assert start_ns == 1_795_176_000 * 10**9  # 2026-11-20T12:00:00+00:00
    times_s = [
        (channel.topic.removeprefix("/events/"), (message.log_time - start_ns) / 1e9)
        for _, channel, message, _ in messages(folder / "late.mcap")
        if channel.topic.removeprefix("/events/") in KINDS
    ]
    assert times_s == [("run.ended", 1.0), ("robot.held", 1.0), ("pose.sampled", 2.0), ("robot.started", 2.0)]


def test_a_log_whose_scenario_is_of_another_version_is_exported_without_a_scene(tmp_path: Path) -> None:
    folder = recorded(tmp_path / "run", numbered((("world", RunEnded(reason="done")),)))
    path = folder / "events.jsonl"
    path.write_bytes(path.read_bytes().replace(b'"fleet":{', b'"fleet":{"captain":1,', 1))
    said = clew("log", "export", folder, "--to", "mcap", "--json")
    assert said.exit_code == 0
    (flaw,) = msgspec.json.decode(said.stdout)["flaws"]
    assert "the export has no scene" in flaw
    assert on(folder / "events.mcap", "/scene") == []
    assert [each["reason"] for each in on(folder / "events.mcap", "/events/run.ended")] == ["done"]
