"""A long log is read without keeping it in memory."""

import os
import subprocess
import sys
from pathlib import Path

import msgspec

from protocol.root import ROOT
from tests.support.logs.long_logs import make

GROWTH_MB_MAX = 20.0  # keeping all entries of the long log takes 97 MB more
LONG = 200_000  # entries


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
