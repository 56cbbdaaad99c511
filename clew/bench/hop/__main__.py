"""`python -m clew.bench.hop KIND ROBOTS NEWS FOLDER`: one chain of relays; prints a `Chain` as JSON.

Rule 1: the relays are forked before this process opens its session, as robots are.
Rule 2: a chain is ready when news has come through; then some more news warms it up.
Rule 3: news that does not come through within `LOST_S` is lost, and counted.
Rule 4: between two pieces of news the chain comes to rest: robots still acknowledge what came before.
"""

import asyncio
import contextlib
import gc
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import msgspec

from clew.bench.hop.chain import Chain
from clew.bench.hop.relay import REACTION, Relay, Say, lead, relay
from clew.bench.hop.strand import Strand

LOST_S = 3.0
READY_S = 60.0
WARM_UP = 5
REST_S, REST_S_EACH = 0.01, 0.0005  # after a piece of news, and for each robot


def main() -> None:
    """Measure one chain."""
    kind, robots, news, folder = Relay(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]), Path(sys.argv[4])
    strand = Strand(robots)
    reading_end, writing_end = os.pipe()
    gc.freeze()  # as the host of robots does
    with _forked(kind, strand, folder, writing_end) as pids:
        prober = _Prober(reading_end, rest_s=REST_S + REST_S_EACH * robots, pids=pids)
        if kind is Relay.STACK:
            prober.on_come(strand.confirm)
        asyncio.run(lead(kind, strand, folder, lambda say: prober.probe(say, news)))
    sys.stdout.buffer.write(msgspec.json.encode(prober.chain(kind, robots)))


@contextlib.contextmanager
def _forked(kind: Relay, strand: Strand, folder: Path, told: int) -> Iterator[Sequence[int]]:
    """The relays, each in a process of its own; killed at the end (rule 1)."""
    pids: list[int] = []
    try:
        for robot in sorted(strand.cores)[1:]:
            pid = os.fork()
            if pid == 0:
                try:
                    relay(kind, robot, strand, folder, told)
                finally:
                    os._exit(1)
            pids.append(pid)
        yield pids
    finally:
        for pid in pids:
            os.kill(pid, signal.SIGKILL)
        for pid in pids:
            os.waitpid(pid, 0)


class _Prober:
    """Puts news, and waits for the last robot's reaction."""

    def __init__(self, told: int, *, rest_s: float, pids: Sequence[int]) -> None:
        self._told, self._rest_s, self._pids = told, rest_s, pids
        self._took_ns: list[int] = []
        self._on_come: Callable[[int], None] | None = None
        self._lost = 0
        self._cpu_ns = 0

    def on_come(self, told: Callable[[int], None]) -> None:
        """Tell it the number of each piece of news that has come through."""
        self._on_come = told

    def chain(self, kind: Relay, robots: int) -> Chain:
        """What was measured."""
        return Chain(
            kind=kind,
            robots=robots,
            took_us=tuple(each / 1000.0 for each in self._took_ns),
            lost=self._lost,
            cpu_us=self._cpu_ns / 1000.0 / (len(self._took_ns) + self._lost) / (robots - 1),
        )

    def probe(self, say: Say, news: int) -> None:
        """Measure so many pieces of news."""
        until_s = time.monotonic() + READY_S
        while self._took(say) is None:
            if time.monotonic() > until_s:
                raise TimeoutError(f"no news has come through the chain for {READY_S:g} s")
        for _ in range(WARM_UP):
            self._took(say)
        since_ns = self._spent_ns()
        for _ in range(news):
            took_ns = self._took(say)
            if took_ns is None:
                self._lost += 1
            else:
                self._took_ns.append(took_ns)
        self._cpu_ns = self._spent_ns() - since_ns

    def _took(self, say: Say) -> int | None:
        """How long one piece of news took; None: it is lost."""
        since_ns = time.monotonic_ns()
        number = say()
        while select.select([self._told], [], [], LOST_S)[0]:
            heard, at_ns = REACTION.unpack(os.read(self._told, REACTION.size))
            if heard == number:
                if self._on_come is not None:
                    self._on_come(number)
                time.sleep(self._rest_s)
                return int(at_ns) - since_ns
        return None

    def _spent_ns(self) -> int:
        """The CPU time of all threads of all relays, as Linux counts it."""
        tasks = (task for pid in self._pids for task in Path(f"/proc/{pid}/task").iterdir())
        return sum(int((task / "schedstat").read_text(encoding="ascii").split()[0]) for task in tasks)


if __name__ == "__main__":
    main()
