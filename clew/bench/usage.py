"""Memory and processor time of a fleet's processes, as the kernel tells them. A shell: it reads /proc.

Rule 1: memory is the proportional set size: pages that processes share are divided among them, so that the
        sum of all is what the fleet takes. The kernel takes milliseconds to find that, so of many robots a
        part is asked.
Rule 2: a process that ends while it is looked at is left out.
"""

import contextlib
import itertools
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from msgspec import Struct
from msgspec.structs import replace

KB = 1024
ROBOTS_ASKED_MAX = 40  # evenly over the fleet: robots of one rank differ by less than a tenth
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
PARTS = {"world": "world", "agents": "robot", "protocol": "router"}
"""Which part of a fleet `python -m` of this module is; a robot's parent is a host."""


class Process(Struct, frozen=True, kw_only=True):
    """What one process has used until now."""

    pid: int
    part: str
    cpu_s: float
    files: int


class Usage(Struct, frozen=True, kw_only=True):
    """What the processes of one part use, in the mean of all."""

    processes: int
    pss_mb: float
    """In the mean of those that were asked (rule 1)."""
    files: float
    """Open descriptors."""


def processes(pids: Mapping[int, str]) -> list[Process]:
    """The processes of a fleet.

    Args:
        pids: their command lines, by process id.
    """
    found: dict[int, tuple[int, Process]] = {}
    for pid, command in pids.items():
        with contextlib.suppress(OSError, IndexError, ValueError):
            fields = Path(f"/proc/{pid}/stat").read_text("ascii", "replace").rpartition(")")[2].split()
            process = Process(
                pid=pid,
                part=_part_of(command.split()),
                cpu_s=(int(fields[11]) + int(fields[12])) / TICKS_PER_S,
                files=sum(1 for _ in Path(f"/proc/{pid}/fd").iterdir()),
            )
            found[pid] = int(fields[1]), process
    parents = {parent for parent, process in found.values() if process.part == "robot"}
    return [
        replace(each, part="host") if each.pid in parents and each.part == "robot" else each
        for _, each in found.values()
    ]


def usage_of(part: str, fleet: Sequence[Process]) -> Usage | None:
    """What a part uses now; None: it has no process."""
    of_part = [each for each in fleet if each.part == part]
    asked = sample(of_part)
    pss_mb = [mb for each in asked if (mb := _pss_mb(each.pid)) is not None]
    if not of_part or not pss_mb:
        return None
    return Usage(
        processes=len(of_part),
        pss_mb=sum(pss_mb) / len(pss_mb),
        files=sum(each.files for each in of_part) / len(of_part),
    )


def sample(processes: Sequence[Process]) -> list[Process]:
    """Those whose memory is asked: evenly over the fleet, and over the ranks in strands of one length."""
    step = max(len(processes) // ROBOTS_ASKED_MAX, 1)
    return [processes[first + first // step % step] for first in range(0, len(processes) - step + 1, step)]


def cpu_s(before: Iterable[Process], after: Iterable[Process]) -> dict[str, float]:
    """The processor time of each part between two looks, of the processes that were there at both."""
    known = {each.pid: each.cpu_s for each in before}
    spent: dict[str, float] = {}
    for each in after:
        if each.pid in known:
            spent[each.part] = spent.get(each.part, 0.0) + each.cpu_s - known[each.pid]
    return spent


def _part_of(words: Sequence[str]) -> str:
    module = next((after for word, after in itertools.pairwise(words) if word == "-m"), "")
    return PARTS.get(module, "launcher")


def _pss_mb(pid: int) -> float | None:
    try:
        with Path(f"/proc/{pid}/smaps_rollup").open(encoding="ascii") as file:
            line = next(line for line in file if line.startswith("Pss:"))
    except (OSError, StopIteration):
        return None
    return int(line.split()[1]) / KB
