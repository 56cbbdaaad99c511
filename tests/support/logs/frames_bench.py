"""How long a table of a long log takes: `python -m tests.support.logs.frames_bench [ENTRIES]`."""

import sys
import tempfile
import time
from importlib.util import find_spec
from pathlib import Path

import clew
from clew.api.frames import DICTS, LIBRARIES
from tests.support.logs.long_logs import make

ENTRIES, ROUNDS = 100_000, 5


def main(entries: int = ENTRIES) -> None:
    """Print the least CPU and wall-clock times of some rounds, from the file and from entries in memory."""
    with tempfile.TemporaryDirectory() as folder:
        run = make(Path(folder) / "run", entries)
        for to in (*filter(find_spec, LIBRARIES), DICTS):
            clew.open(run).frame("robot.held", to=to)  # the library is loaded
            for name in ("poses", "entries"):
                opened = [clew.open(run) for _ in range(ROUNDS)]
                read, kept = ([_timed(each, name, to) for each in opened] for _ in range(2))
                times = f"from the file {_told(read)}; from memory {_told(kept)}"
                sys.stdout.write(f"{name} of {entries} entries as {to}: {times}\n")


def _timed(run: clew.Run, name: str, to: str) -> tuple[float, float]:
    cpu_s, wall_s = time.process_time(), time.perf_counter()
    run.frame(name, to=to)
    return time.process_time() - cpu_s, time.perf_counter() - wall_s


def _told(times: list[tuple[float, float]]) -> str:
    cpu_s, wall_s = map(min, zip(*times, strict=True))
    return f"{cpu_s:.2f} s of CPU, {wall_s:.2f} s of wall clock"


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
