"""A world that can be reached: then its run is not over, however slowly a test writes it."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from protocol.faults.manual_faults import WHERE_FILE

LOOKS_MAX = 100  # nobody accepts them; a look comes every ten seconds


@contextmanager
def reachable_world(run: Path) -> Iterator[None]:
    """While the context lasts, a world of this run takes requests, and answers none."""
    with (
        TemporaryDirectory(prefix="ct.", dir="/tmp") as private,  # pytest's path may be too long for a socket
        socket.socket(socket.AF_UNIX) as world,
    ):
        where = Path(private) / "w.sock"
        world.bind(str(where))
        world.listen(LOOKS_MAX)
        (run / WHERE_FILE).write_text(str(where), encoding="utf-8")
        yield
        (run / WHERE_FILE).unlink()
