"""The two routers of a fleet: each carries it alone, they find each other again, and trust nobody else."""

import asyncio
import contextlib
import json
import signal
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
import zenoh

from protocol.keys import WORLD
from protocol.network.session import read_session, unix_socket_endpoint, write_sessions
from protocol.network.settings import client_settings
from protocol.network.transport import Heard
from tests.support.deadline import DEADLINE_S
from tests.support.processes.wire import (
    KEYS,
    arrivals_until,
    drive,
    next_arrivals,
    python,
    robot_transport,
    world_transport,
)


@pytest.fixture
def two() -> Iterator[Path]:
    """The sessions of a fleet with two routers. The folder's path is short enough for Unix sockets."""
    with TemporaryDirectory(prefix="ct.", dir="/tmp") as path:
        folder = Path(path)
        endpoints = [unix_socket_endpoint(folder, number) for number in (1, 2)]
        write_sessions(folder, fleet=KEYS.fleet, run=KEYS.run, robots=3, endpoints=endpoints)
        yield folder


@contextlib.contextmanager
def router(folder: Path, number: int) -> Iterator[subprocess.Popen[str]]:
    """One of the two routers, listening."""
    with python(
        "-m", "protocol", "--sessions", str(folder), "--number", str(number), "--lifeline"
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith("ready ")
        yield process


@contextlib.contextmanager
def client(folder: Path, name: str, only: int) -> Iterator[zenoh.Session]:
    """A bare session of a process at one of the routers."""
    settings = client_settings(read_session(folder / f"{name}.json"))
    settings["connect"]["endpoints"] = [unix_socket_endpoint(folder, only)]
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as opened:
        yield opened


async def test_clients_fail_over_when_a_router_dies_and_both_routers_enforce_the_rules(two: Path) -> None:
    with ExitStack() as stack:
        routers = [stack.enter_context(router(two, number)) for number in (1, 2)]
        world = stack.enter_context(world_transport(two))
        robot = stack.enter_context(robot_transport(two, "r1"))
        await arrivals_until(world, bool)  # its token
        numbers = count()

        async def hear(messages: int) -> None:
            """Send until this many messages arrive. Messages sent while the router is down are lost."""
            heard = 0
            while heard < messages:
                number = next(numbers)
                robot.put(KEYS.drive("r1"), drive(number))
                robot.put(KEYS.odometry("r1"), drive(number))  # a robot may not publish this
                said = [each for each in await world.arrivals(0.002) if isinstance(each, Heard)]
                assert {each.key for each in said} <= {KEYS.drive("r1")}
                heard += len(said)

        async with asyncio.timeout(DEADLINE_S):
            await hear(100)
            routers[0].kill()
            await hear(100)


@pytest.mark.parametrize("first", ["away", "frozen"])
async def test_a_new_process_gets_its_session_through_the_second_router_alone(two: Path, first: str) -> None:
    with ExitStack() as stack:
        if first == "frozen":
            stack.enter_context(router(two, 1)).send_signal(signal.SIGSTOP)
        stack.enter_context(router(two, 2))
        world, robot = (
            stack.enter_context(world_transport(two)),
            stack.enter_context(robot_transport(two, "r1")),
        )
        await arrivals_until(world, bool)
        robot.put(KEYS.drive("r1"), drive(1))
        assert await next_arrivals(world) == [Heard(KEYS.drive("r1"), 1, drive(1))]


async def heard_across(two: Path) -> bool:
    """Whether a world at the second router hears a robot that is at the first."""
    heard = False
    with client(two, WORLD, only=2) as world, client(two, "r1", only=1) as robot:
        listened = world.declare_subscriber(KEYS.drive("*"))
        async with asyncio.timeout(DEADLINE_S):
            while not heard:
                robot.put(KEYS.drive("r1"), b"x")
                await asyncio.sleep(0.05)
                heard = listened.try_recv() is not None
    return heard


@pytest.mark.parametrize("killed", [1, 2])
async def test_the_routers_find_each_other_whichever_is_started_again(two: Path, killed: int) -> None:
    with ExitStack() as stack:
        routers = {number: stack.enter_context(router(two, number)) for number in (1, 2)}
        assert await heard_across(two)
        routers[killed].kill()
        routers[killed].wait(DEADLINE_S)
        stack.enter_context(router(two, killed))
        assert await heard_across(two)


async def turn_away(two: Path, tries: int) -> None:
    """Close so many connections at the socket of the first router, and leave."""
    path, came = unix_socket_endpoint(two, 1).partition("/")[2], asyncio.Semaphore(0)

    def close(_: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        writer.close()
        came.release()

    async with asyncio.timeout(DEADLINE_S), await asyncio.start_unix_server(close, path):
        for _ in range(tries):
            await came.acquire()


async def test_the_second_router_finds_a_first_that_comes_later(two: Path) -> None:
    with router(two, 2), client(two, WORLD, only=2):
        await turn_away(two, tries=3)  # and while the first one starts, it finds nobody there
        with router(two, 1):
            assert await heard_across(two)


async def test_a_stranger_at_the_socket_of_the_first_router_is_not_taken_for_it(two: Path) -> None:
    stranger = {
        "mode": "router",
        "listen": {"endpoints": [unix_socket_endpoint(two, 1)]},
        "scouting": {"multicast": {"enabled": False}},
    }
    with (
        zenoh.open(zenoh.Config.from_json5(json.dumps(stranger))) as forger,
        router(two, 2),
        client(two, WORLD, only=2) as world,
        client(two, "r2", only=2) as honest,
    ):
        listened = world.declare_subscriber(KEYS.drive("*"))
        async with asyncio.timeout(DEADLINE_S):
            heard: list[str] = []
            while KEYS.drive("r2") not in heard:
                forger.put(KEYS.drive("r1"), b"x")
                honest.put(KEYS.drive("r2"), b"x")
                await asyncio.sleep(0.05)
                while (sample := listened.try_recv()) is not None:
                    heard.append(str(sample.key_expr))
    assert set(heard) == {KEYS.drive("r2")}
