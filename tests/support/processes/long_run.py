"""How long a world takes from SIGTERM to its verdict, after so many entries.

`python -m tests.support.processes.long_run [ENTRIES]` measures it: a world goes on from a log that was made,
reads and judges all of it, and is then told to end.
"""

import asyncio
import contextlib
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from msgspec import Struct

from protocol.keys import Keys, robot_name
from protocol.network.session import read_session, unix_socket_endpoint, write_sessions
from protocol.network.zenoh_transport import open_transport
from tests.support.logs.driving_logs import ORDER, make
from tests.support.processes.fleets import wait_until
from tests.support.processes.wire import python, router
from world.judge.verdict import VERDICT_FILE, Verdict
from world.record.recorder import EVENTS_FILE
from world.record.run_files import read_verdict

KEYS = Keys("f", "t")


class LongRun(Struct, frozen=True, kw_only=True):
    """What was measured."""

    entries: int
    caught_up_s: float
    """Until the world had read and judged the whole log."""
    verdict_s: float
    """From SIGTERM until the verdict was there."""
    memory_mb: float
    """The world's largest memory while it judged."""
    verdict: Verdict


async def measure(entries: int) -> LongRun:
    """Let a world go on from a log of so many entries, and end it."""
    with contextlib.ExitStack() as stack:
        private = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="clew", dir="/tmp")))
        run = make(private / "run", entries)
        endpoints = [unix_socket_endpoint(private)]
        write_sessions(private, fleet=KEYS.fleet, run=KEYS.run, robots=len(ORDER), endpoints=endpoints)
        stack.enter_context(router(private))
        tokens = stack.enter_context(contextlib.ExitStack())
        for robot in ORDER:  # only their tokens: a world without robots would end by itself
            alive = KEYS.alive(robot_name(robot), "1")
            session = read_session(private / f"{robot_name(robot)}.json")
            tokens.enter_context(open_transport(session, hear=[], answer=[], alive=alive, watch=()))
        begun_s = time.monotonic()
        world = stack.enter_context(
            python("-m", "world", str(run), "--session", str(private / "world.json"), "--resume")
        )
        wait_until(lambda: _has_read(world, run / EVENTS_FILE) or None, timeout_s=3600.0)
        caught_up_s, memory_mb = time.monotonic() - begun_s, _peak_mb(world.pid)
        tokens.close()  # the world would wait for the last words of robots that are there
        assert not (run / VERDICT_FILE).exists(), "it has ended by itself"
        told_s = time.monotonic()
        world.send_signal(signal.SIGTERM)
        wait_until(lambda: (run / VERDICT_FILE).exists() or None, timeout_s=3600.0)
        verdict_s = time.monotonic() - told_s
        world.wait()
        return LongRun(
            entries=entries,
            caught_up_s=caught_up_s,
            verdict_s=verdict_s,
            memory_mb=memory_mb,
            verdict=read_verdict(run),
        )


def _has_read(world: subprocess.Popen[str], path: Path) -> bool:
    """Whether the world, which has the file open for writing, has read it to its end, too."""
    assert world.poll() is None, world.communicate()[1]
    at: list[int] = []
    for descriptor in Path(f"/proc/{world.pid}/fd").iterdir():
        with contextlib.suppress(OSError):  # it has just been closed
            if descriptor.readlink() == path:
                info = Path(f"/proc/{world.pid}/fdinfo/{descriptor.name}").read_text(encoding="ascii")
                at.append(int(info.split()[1]))
    return len(at) == 2 and min(at) >= path.stat().st_size


def _peak_mb(pid: int) -> float:
    fields = Path(f"/proc/{pid}/status").read_text(encoding="ascii").split()
    return int(fields[fields.index("VmHWM:") + 1]) / 1024


if __name__ == "__main__":
    measured = asyncio.run(measure(int((sys.argv[1:] or ["1000000"])[0])))
    reason, events = measured.verdict.reason, measured.verdict.events
    sys.stdout.write(
        f"{measured.entries} entries, read and judged in {measured.caught_up_s:.1f} s; "
        f"from SIGTERM to the verdict {measured.verdict_s:.3f} s; {measured.memory_mb:.0f} MB; "
        f"{events.recorded} recorded, {events.lost} lost; {reason}\n"
    )
