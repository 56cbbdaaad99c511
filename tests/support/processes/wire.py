"""For tests over real Zenoh: a router process, sessions, messages, and waiting for arrivals."""

import asyncio
import contextlib
import shutil
import subprocess
import sys
import tempfile
from collections.abc import AsyncIterator, Callable, Iterator, Sequence
from pathlib import Path

from protocol.fence import Bearing, Fence
from protocol.frames import Pose
from protocol.keys import WORLD, Keys
from protocol.network.session import read_session, unix_socket_endpoint, write_sessions
from protocol.network.transport import Arrival
from protocol.network.zenoh_transport import ZenohTransport, open_transport
from protocol.root import ROOT
from protocol.wire.messages import Drive, Odometry, Phase
from tests.support.deadline import DEADLINE_S

KEYS = Keys("f", "t")
TOKEN = "1"
"""The incarnation of every process that a test plays."""
ORIGIN = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)


@contextlib.contextmanager
def session_folder(*, run: str = KEYS.run) -> Iterator[Path]:
    """A folder whose path is short enough for a socket, with the sessions of three robots and a world."""
    folder = Path(tempfile.mkdtemp(prefix="clew"))
    try:
        endpoint = unix_socket_endpoint(folder)
        write_sessions(folder, fleet=KEYS.fleet, run=run, robots=3, endpoints=[endpoint])
        yield folder
    finally:
        shutil.rmtree(folder)


@contextlib.contextmanager
def python(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A Python process of ours, which always ends with the context."""
    command = [sys.executable, *arguments]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=ROOT, stdin=pipe, stdout=pipe, stderr=pipe, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


@contextlib.contextmanager
def router(folder: Path, *, lifeline: bool = True) -> Iterator[subprocess.Popen[str]]:
    """The fleet's router, listening; its lifeline ends it if the test is killed."""
    options = ["--lifeline"] if lifeline else []
    with python("-m", "protocol", "--sessions", str(folder), *options) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert line.startswith("ready "), line + process.communicate(timeout=DEADLINE_S)[1]
        yield process


@contextlib.contextmanager
def world_transport(folder: Path, *, alive: str | None = None) -> Iterator[ZenohTransport]:
    """A transport with the world's subscriptions, queries and watches; by default without a token."""
    session = read_session(folder / f"{WORLD}.json")
    with open_transport(
        session,
        hear=[KEYS.drive("*"), KEYS.fence("*"), KEYS.log("*")],
        answer=[KEYS.scan("*"), KEYS.mission()],
        alive=alive,
        watch=[KEYS.tokens_of("*")],
    ) as transport:
        yield transport


@contextlib.contextmanager
def robot_transport(folder: Path, name: str, *, watch: Sequence[str] = ()) -> Iterator[ZenohTransport]:
    """A transport with a robot's subscriptions and its token; by default it watches no tokens."""
    session = read_session(folder / f"{name}.json")
    hear = [KEYS.link("*", name), KEYS.odometry(name), KEYS.view("*", name), KEYS.logged(name)]
    with open_transport(
        session, hear=hear, answer=[], alive=KEYS.alive(name, TOKEN), watch=watch
    ) as transport:
        yield transport


async def arrivals_until(
    transport: ZenohTransport, enough: Callable[[Sequence[Arrival]], bool]
) -> list[Arrival]:
    """All arrivals, up to the burst after which `enough` is true; fails after the deadline."""
    arrived: list[Arrival] = []
    async with asyncio.timeout(DEADLINE_S):
        while not enough(arrived):
            arrived += await transport.arrivals(None)
    return arrived


async def arrivals_besides(transport: ZenohTransport, key: str) -> list[Arrival]:
    """Wait for an arrival under this key; returns all other arrivals until then."""
    arrived = await arrivals_until(transport, lambda arrived: key in [each.key for each in arrived])
    return [each for each in arrived if each.key != key]


async def next_arrivals(transport: ZenohTransport, count: int = 1) -> list[Arrival]:
    """All arrivals, up to the burst that brings this many."""
    return await arrivals_until(transport, lambda arrived: len(arrived) >= count)


def drive(number: int) -> Drive:
    """An order to stand still."""
    return Drive(
        number=number, basis_s=0.0, target=None, speed_mps=0.0, bearing=Bearing(), step=0, reach_m=0.0
    )


def odometry(t_s: float) -> Odometry:
    """The odometry of a body that stands at the origin."""
    return Odometry(n=1, t_s=t_s, pose=ORIGIN, moving=False, finished=0, fence=Fence(), phase=Phase.RUNNING)


@contextlib.asynccontextmanager
async def fleet(folder: Path, *names: str) -> AsyncIterator[list[ZenohTransport]]:
    """The world and these robots, after the router has learned all their subscriptions."""
    with contextlib.ExitStack() as stack:
        world = stack.enter_context(world_transport(folder))
        robots = [stack.enter_context(robot_transport(folder, name)) for name in names]
        await arrivals_until(world, lambda arrived: len(arrived) >= len(names))
        yield [world, *robots]
