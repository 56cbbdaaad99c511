import errno
import json
import os
import signal
import subprocess
import sys
from io import FileIO
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.errors import UsageError
from protocol.fence import May
from protocol.timeline import Entry, FenceChanged, LinkHeard, RobotReleased
from world.record.recorder import SCHEMA, Header, Recorder, RecordingFailedError, line, open_events

HEADER = Header(
    run="run7",
    seed=1,
    speed=1.0,
    started_at="2026-11-20T00:00:00Z",
    scenario={"name": "none"},
    scenario_hash="0",
    versions={},
)

WRITER = """
import sys
from pathlib import Path
from tests.unit.world.record.test_recorder import HEADER, entries
from world.record.recorder import Recorder, open_events
recorder = Recorder(open_events(Path(sys.argv[1])), HEADER)
for entry in entries(1500):
    recorder.take("r1", [entry])
print("written", flush=True)
sys.stdin.read()
"""


def entries(count: int) -> list[Entry]:
    return [entry(n) for n in range(1, count + 1)]


def entry(n: int) -> Entry:
    return Entry(n=n, t_s=n / 100, hlc=f"hlc{n}", record=LinkHeard(neighbour=n % 5 + 1))


def numbers(folder: Path) -> list[tuple[str, int]]:
    lines = (folder / "events.jsonl").read_text().splitlines()[1:]
    return [(fields["source"], fields["n"]) for fields in map(json.loads, lines)]


def test_the_header_comes_first_and_an_entry_is_one_flat_object(tmp_path: Path) -> None:
    with open_events(tmp_path / "runs" / "a") as file:
        Recorder(file, HEADER).take("r1", [entry(1)])
    header, event = map(json.loads, (tmp_path / "runs" / "a" / "events.jsonl").read_text().splitlines())
    assert (header["kind"], header["schema"], header["run"]) == ("run.started", SCHEMA, "run7")
    expected = {"t_s": 0.01, "hlc": "hlc1", "source": "r1", "n": 1, "kind": "link.heard", "neighbour": 2}
    assert event == expected
    assert list(event)[:5] == ["t_s", "hlc", "source", "n", "kind"]


def test_a_record_without_fields_is_a_complete_line() -> None:
    assert (
        json.loads(line("r1", Entry(n=1, t_s=0.0, hlc="", record=RobotReleased())))["kind"]
        == "robot.released"
    )


def test_sigkill_loses_nothing_of_1500_entries(tmp_path: Path) -> None:
    command = [sys.executable, "-c", WRITER, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == "written\n"
        os.kill(writer.pid, signal.SIGKILL)
    assert numbers(tmp_path) == [("r1", n) for n in range(1, 1501)]


@settings(deadline=None)  # it writes files
@given(batches=st.lists(st.lists(st.integers(1, 12), max_size=5), max_size=30))
def test_a_source_is_written_once_and_in_order_under_loss_repetition_and_reordering(
    batches: list[list[int]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("run")
    written = 0
    with open_events(folder) as file:
        recorder = Recorder(file, HEADER)
        for batch in batches:
            for n in batch:
                written += n == written + 1
            recorder.take("r1", [entry(n) for n in batch])
            assert recorder.up_to("r1") == written
    assert numbers(folder) == [("r1", n) for n in range(1, written + 1)]
    newest = max((n for batch in batches for n in batch), default=0)
    assert sum(recorder.missing.values()) == newest - written


def test_sources_are_counted_separately(tmp_path: Path) -> None:
    with open_events(tmp_path) as file:
        recorder = Recorder(file, HEADER)
        recorder.take("r1", entries(3))
        recorder.take("r2", [entry(2), entry(3)])
        assert (recorder.up_to("r1"), recorder.up_to("r2")) == (3, 0)
        assert (recorder.recorded_count, recorder.missing) == (3, {"r2": 3})
        assert [each.n for each in recorder.take("r2", entries(3))] == [1, 2, 3]
        assert (recorder.recorded_count, recorder.missing) == (6, {})


def test_a_restarted_source_counts_from_one_and_its_earlier_incarnation_is_ignored(
    tmp_path: Path,
) -> None:
    with open_events(tmp_path) as file:
        recorder = Recorder(file, HEADER)
        recorder.take("r1", [entry(1), entry(2), entry(4)], "first")
        assert recorder.missing == {"r1": 2}
        assert recorder.take("r1", [entry(2)], "second") == []  # its first entry has not arrived yet
        assert len(recorder.take("r1", [entry(3)], "first")) == 1
        assert len(recorder.take("r1", entries(2), "second")) == 2
        assert recorder.take("r1", [entry(4)], "first") == []
        assert (recorder.up_to("r1", "first"), recorder.up_to("r1", "second")) == (3, 2)
        assert recorder.missing == {}
    assert numbers(tmp_path) == [("r1", n) for n in (1, 2, 3, 1, 2)]


def test_a_folder_that_cannot_be_written_is_refused_in_one_clear_line(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match=r"cannot be written: .*/file is no folder"):
        open_events(tmp_path / "file")


def test_a_run_never_overwrites_another(tmp_path: Path) -> None:
    open_events(tmp_path).close()
    with pytest.raises(UsageError, match="recorded there already"):
        open_events(tmp_path)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_ends_the_recording_with_its_reason() -> None:
    with FileIO("/dev/full", "w") as full, pytest.raises(RecordingFailedError, match="No space left"):
        Recorder(full, HEADER)


FENCE = FenceChanged(epoch=10002, turn=0, may=May.NOBODY, coordinator=2, life="a")


def test_a_fence_is_on_the_disk_before_anyone_acts_on_it_and_nothing_else_waits_for_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[bytes] = []
    path = tmp_path / "events.jsonl"
    monkeypatch.setattr(os, "fdatasync", lambda _: synced.append(path.read_bytes()))
    with open_events(tmp_path) as file:
        recorder = Recorder(file, HEADER)
        recorder.take("world", [entry(1)])
        recorder.take("r1", [Entry(n=1, t_s=0.01, hlc="hlc1", record=FENCE)])  # a robot's word changes none
        assert synced == []
        fence = Entry(n=2, t_s=0.02, hlc="hlc2", record=FENCE)
        recorder.take("world", [fence, entry(3)])
        assert synced == [path.read_bytes()]
        assert line("world", fence) in synced[0]


def test_a_disk_that_cannot_sync_a_fence_ends_the_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fdatasync", fail)
    with open_events(tmp_path) as file, pytest.raises(RecordingFailedError, match="cannot sync"):
        Recorder(file, HEADER).take("world", [Entry(n=1, t_s=0.0, hlc="", record=FENCE)])
