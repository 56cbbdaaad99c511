"""A long log is read without keeping it in memory, and an interrupted export leaves nothing."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S
from tests.support.logs.long_logs import make

GROWTH_MB_MAX = 20.0  # keeping all entries of the long log takes 97 MB more
LONG = 200_000  # entries: their export takes a second or more


def clew(*arguments: str | Path) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", "clew.cli", *map(str, arguments)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def test_memory_does_not_grow_with_a_log_and_no_entry_is_dropped(tmp_path: Path) -> None:
    short_mb, long_mb = (peak_mb(make(tmp_path / str(entries), entries), entries) for entries in (1000, LONG))
    assert long_mb - short_mb < GROWTH_MB_MAX


def peak_mb(run: Path, entries: int) -> float:
    """The peak memory of `log info` on a log of this many entries; checks that it counts all of them."""
    with clew("log", "info", run, "--json") as process:
        assert process.stdout is not None
        said = msgspec.json.decode(process.stdout.read())
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert (said["entries"], said["flaws"]) == (entries, [])
    return usage.ru_maxrss / 1024


@pytest.mark.parametrize("to", ["mcap", "csv"])
def test_an_interrupted_export_leaves_nothing(tmp_path: Path, to: str) -> None:
    run = make(tmp_path / "run", LONG)
    before = set(run.iterdir())
    with clew("log", "export", run, "--to", to) as process:
        assert next(drafts(run, process)).suffix == ".part"
        process.send_signal(signal.SIGINT)
        assert process.wait(DEADLINE_S) == 130
    assert set(run.iterdir()) == before


def drafts(run: Path, process: subprocess.Popen[bytes]) -> Iterator[Path]:
    """The file that an export has begun to write, as soon as it exists."""
    while process.poll() is None:
        yield from run.glob(".*.part")
