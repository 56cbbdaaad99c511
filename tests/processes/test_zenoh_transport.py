"""The transport over real Zenoh: a router in a process of its own, sessions with passwords, a Unix socket."""

import asyncio
import contextlib
import json
import signal
import threading
import time
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import zenoh

from protocol.errors import UsageError
from protocol.fence import Fence
from protocol.network import zenoh_transport
from protocol.network.session import read_session
from protocol.network.settings import client_settings
from protocol.network.transport import Appeared, Arrival, Asked, Heard, Listed, Vanished
from protocol.network.zenoh_transport import ZenohTransport
from protocol.wire.codec import encode
from protocol.wire.messages import Ask, Scan
from tests.support.deadline import DEADLINE_S
from tests.support.processes.fleets import wait_until
from tests.support.processes.wire import (
    KEYS,
    ORIGIN,
    arrivals_until,
    drive,
    fleet,
    next_arrivals,
    odometry,
    python,
    robot_transport,
    router,
    session_folder,
    world_transport,
)

BURST = 300  # enough to overflow Zenoh's short queue for express messages
SCAN = Scan(t_s=0.0, pose=ORIGIN, fence=Fence(), ranges_m=(1.0,) * 8)
RETOLD_S = 0.1  # a hundred times the latency of a message
TOKEN = KEYS.alive("r1", "1")


@pytest.fixture
def folder() -> Iterator[Path]:
    with session_folder() as folder, router(folder):
        yield folder


async def test_messages_between_robot_and_world_arrive_numbered_and_counted(folder: Path) -> None:
    async with fleet(folder, "r1") as (world, robot):
        robot.put(KEYS.drive("r1"), drive(1))
        robot.put(KEYS.drive("r1"), drive(2))
        assert await next_arrivals(world, 2) == [Heard(KEYS.drive("r1"), n, drive(n)) for n in (1, 2)]
        world.put(KEYS.odometry("r1"), odometry(0.5))
        assert await next_arrivals(robot) == [Heard(KEYS.odometry("r1"), 1, odometry(0.5))]
    assert robot.traffic.sent == {KEYS.drive("r1"): 2}
    assert world.traffic.received == {KEYS.drive("r1"): 2}
    assert world.traffic.newest == {KEYS.drive("r1"): 2}
    assert robot.traffic.received == {KEYS.odometry("r1"): 1}


async def test_a_burst_on_two_keys_arrives_in_sending_order(folder: Path) -> None:
    two_keys = (KEYS.link("r1", "r2"), KEYS.view("r1", "r2"))
    sent = [Heard(two_keys[n % 2], n // 2 + 1, drive(n)) for n in range(BURST)]
    async with fleet(folder, "r1", "r2") as (_, sender, receiver):
        for each in sent:
            sender.put(each.key, each.message)
        assert await next_arrivals(receiver, BURST) == sent


async def test_causal_order_holds_across_three_clients(
    folder: Path,
) -> None:
    async with fleet(folder, "r1", "r2") as (world, sender, receiver):
        for n in range(1, BURST + 1):
            for _ in range(5):
                sender.put(KEYS.link("r1", "r2"), drive(n))
            sender.put(KEYS.drive("r1"), drive(n))
            await next_arrivals(world)
            world.put(KEYS.odometry("r2"), odometry(float(n)))
            arrived = await arrivals_until(
                receiver, lambda arrived: KEYS.odometry("r2") in [each.key for each in arrived]
            )
            assert [each.key for each in arrived] == [KEYS.link("r1", "r2")] * 5 + [KEYS.odometry("r2")]


async def test_a_robot_receives_messages_as_soon_as_its_token_is_seen(folder: Path) -> None:
    with world_transport(folder) as world:
        for _ in range(20):
            with robot_transport(folder, "r1") as robot:
                assert await next_arrivals(world) == [Appeared(TOKEN)]
                world.put(KEYS.odometry("r1"), odometry(0.0))
                assert len(await next_arrivals(robot)) == 1
            assert await next_arrivals(world) == [Vanished(TOKEN)]


async def test_a_query_is_answered_and_not_counted_as_a_message(folder: Path) -> None:
    async with fleet(folder, "r1") as (world, robot):
        robot.ask(KEYS.scan("r1"), Ask())
        (asked,) = await next_arrivals(world)
        assert isinstance(asked, Asked)
        assert (asked.key, asked.message) == (KEYS.scan("r1"), Ask())
        asked.answer(SCAN)
        assert await next_arrivals(robot) == [Heard(KEYS.scan("r1"), 0, SCAN)]
    assert (robot.traffic.sent, robot.traffic.received, world.traffic.received) == ({}, {}, {})


async def test_an_unanswered_query_brings_nothing_and_may_be_repeated(folder: Path) -> None:
    async with fleet(folder, "r1") as (world, robot):
        robot.ask(KEYS.scan("r1"), Ask())
        (unanswered,) = await next_arrivals(world)
        assert await robot.arrivals(1.5) == []  # Zenoh gives up the query after 1 s
        robot.ask(KEYS.scan("r1"), Ask())
        (asked,) = await next_arrivals(world)
        assert isinstance(unanswered, Asked)
        assert isinstance(asked, Asked)
        unanswered.answer(SCAN)  # too late: ignored
        asked.answer(SCAN)
        assert await next_arrivals(robot) == [Heard(KEYS.scan("r1"), 0, SCAN)]


async def test_the_token_of_a_killed_process_vanishes(folder: Path) -> None:
    with (
        world_transport(folder) as world,
        python("-m", "tests.support.processes.wire_child", str(folder / "r1.json")) as child,
    ):
        token = KEYS.alive("r1", "child")
        assert await next_arrivals(world) == [Appeared(token)]
        child.send_signal(signal.SIGKILL)
        assert await next_arrivals(world) == [Vanished(token)]


async def test_tokens_declared_before_the_watch_began_are_seen(folder: Path) -> None:
    with robot_transport(folder, "r1"), robot_transport(folder, "r2"), world_transport(folder) as world:
        tokens = {Appeared(TOKEN), Appeared(KEYS.alive("r2", "1"))}
        assert set(await next_arrivals(world, 2)) == tokens


def test_a_process_that_raises_ends_and_does_not_hang(folder: Path) -> None:
    with python("-m", "tests.support.processes.wire_child", str(folder / "r1.json"), "breaks") as child:
        output, errors = child.communicate(timeout=DEADLINE_S)
    assert (output, child.returncode) == ("alive\n", 1)
    assert "broken on purpose" in errors


async def test_a_client_does_not_receive_its_own_messages(folder: Path) -> None:
    async with fleet(folder, "r1", "r2") as (_, robot, other):
        robot.put(KEYS.view("r1", "r2"), drive(1))
        await next_arrivals(other)
        other.put(KEYS.view("r2", "r1"), drive(2))
        assert await next_arrivals(robot) == [Heard(KEYS.view("r2", "r1"), 1, drive(2))]


async def test_messages_dropped_by_a_full_inbox_are_counted(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(zenoh_transport, "INBOX_CAPACITY", 4)
    async with fleet(folder, "r1", "r2") as (_, sender, receiver):
        for n in range(1, 11):
            sender.put(KEYS.link("r1", "r2"), drive(n))
        deadline_s = time.monotonic() + DEADLINE_S
        while (
            receiver.traffic.overflowed_count < 6
        ):  # the network thread counts, without an event to wait for
            assert time.monotonic() < deadline_s
        others_turn = asyncio.Event()
        asyncio.get_running_loop().call_soon(others_turn.set)
        newest = [Heard(KEYS.link("r1", "r2"), n, drive(n)) for n in range(7, 11)]
        assert await receiver.arrivals(None) == newest
        assert others_turn.is_set()  # a flood of arrivals does not starve the loop's other tasks


async def test_a_query_counts_in_a_full_inbox_with_all_that_it_carries(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(zenoh_transport, "INBOX_BYTES_MAX", 50_000)
    settings, more = client_settings(read_session(folder / "r1.json")), 30_000 * "x"
    async with fleet(folder) as (world,):
        with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
            for asked, attached in (("", more), (f"?{more}", None), ("", more)):
                session.get(KEYS.mission() + asked, lambda _: None, payload=b"any", attachment=attached)
            deadline_s = time.monotonic() + DEADLINE_S
            while world.traffic.overflowed_count < 2:
                assert time.monotonic() < deadline_s
        assert len(await world.arrivals(0.0)) == 1


async def test_arrivals_are_empty_after_the_timeout(folder: Path) -> None:
    async with fleet(folder, "r1") as (world, robot):
        world.put(KEYS.odometry("r1"), odometry(0.0))
        assert len(await next_arrivals(robot)) == 1
        assert await robot.arrivals(0.0) == []
        assert await robot.arrivals(0.05) == []


async def test_without_a_router_calls_neither_raise_nor_block_and_traffic_resumes_with_it() -> None:
    with session_folder() as folder, router(folder) as first:
        async with fleet(folder, "r1") as (world, robot):
            first.kill()
            first.wait(DEADLINE_S)
            assert await next_arrivals(world) == [Vanished(TOKEN)]
            began_s = time.monotonic()
            for n in range(1, BURST + 1):
                robot.put(KEYS.drive("r1"), drive(n))
                robot.ask(KEYS.mission(), Ask())
            assert time.monotonic() - began_s < DEADLINE_S
            with router(folder):
                assert await next_arrivals(world) == [Appeared(TOKEN)]
                heard = await heard_again(world, robot)
            assert isinstance(heard, Heard)
            assert (heard.message, heard.number > BURST) == (drive(0), True)


async def heard_again(world: ZenohTransport, robot: ZenohTransport) -> Arrival:
    """The first message to arrive; it is sent again and again, as a new router learns subscriptions late."""
    async with asyncio.timeout(DEADLINE_S):
        while True:
            robot.put(KEYS.drive("r1"), drive(0))
            if arrived := await world.arrivals(RETOLD_S):
                return arrived[0]


async def test_after_close_a_put_and_a_query_are_lost_and_raise_nothing(folder: Path) -> None:
    with robot_transport(folder, "r1") as robot:
        pass
    robot.put(KEYS.drive("r1"), drive(1))
    robot.ask(KEYS.mission(), Ask())
    assert await robot.arrivals(0.0) == []


async def test_a_missing_router_is_reported_to_the_user() -> None:
    with (
        session_folder() as folder,
        pytest.raises(UsageError, match="no router answers at unixsock-stream/"),
        robot_transport(folder, "r1"),
    ):
        pass


async def test_a_process_tries_again_with_a_new_session_while_its_router_starts() -> None:
    with (
        session_folder() as folder,
        python("-m", "protocol", "--sessions", str(folder)),
        robot_transport(folder, "r1") as robot,
    ):
        assert robot.router is not None


async def test_time_stamps_of_a_process_increase_strictly(folder: Path) -> None:
    with robot_transport(folder, "r1") as robot:
        stamps = [robot.timestamp().split("/") for _ in range(BURST)]
    assert [int(ticks) for ticks, _ in stamps] == sorted({int(ticks) for ticks, _ in stamps})
    assert len({source for _, source in stamps}) == 1


async def test_a_clock_that_was_set_back_silences_nobody(folder: Path) -> None:
    ahead = zenoh.Timestamp(datetime.now(UTC) + timedelta(hours=1), b"a")  # clocks of Zenoh never go back
    settings, key = client_settings(read_session(folder / "r1.json")), KEYS.drive("r1")
    config = zenoh.Config.from_json5(json.dumps(settings))
    arrived: list[Arrival] = []
    with world_transport(folder) as world, zenoh.open(config) as robot:
        while not arrived:  # until the router knows what the world listens to
            robot.put(key, encode(drive(1), 1, key), timestamp=ahead)
            robot.put(key, encode(drive(2), 2, key))
            arrived += await world.arrivals(RETOLD_S)
    assert arrived[0] == Heard(key, 1, drive(1))


async def test_what_is_watched_can_change_and_the_tokens_that_are_shown_are_listed(folder: Path) -> None:
    async with fleet(folder, "r1", "r2", "r3") as (_, first, *_others):
        first.watch([KEYS.tokens_of("r2")])
        arrived = await arrivals_until(first, lambda arrived: Listed() in arrived)
        assert set(arrived) == {Appeared(KEYS.alive("r2", "1")), Listed()}  # it may be told twice
        assert arrived.index(Listed()) > 0, "behind the tokens"
        first.watch([KEYS.tokens_of("*")])
        arrived = await arrivals_until(first, lambda arrived: Listed() in arrived)
        assert {each.key for each in arrived} >= {KEYS.alive(f"r{robot}", "1") for robot in (1, 2, 3)}
        first.watch([KEYS.tokens_of("r9")])
        arrived = await arrivals_until(first, lambda arrived: Listed() in arrived)
        assert arrived == [Listed()], "nothing is shown there, and nothing else is watched"


def test_one_thread_of_a_client_receives(folder: Path) -> None:
    with python("-m", "tests.support.processes.wire_child", str(folder / "r1.json")) as child:
        assert child.stdout is not None
        assert child.stdout.readline() == "alive\n"
        # Zenoh starts another one in the place of one that has ended, so for a moment there may be none.
        receiving = wait_until(lambda: threads_of(child.pid, "rx-") or None)
    assert len(receiving) == 1


def threads_of(pid: int, prefix: str) -> list[str]:
    """The names of a process's threads that begin like this."""
    names = []
    for name in Path(f"/proc/{pid}/task").glob("*/comm"):
        with contextlib.suppress(OSError):
            names.append(name.read_text())
    return [name for name in names if name.startswith(prefix)]


async def test_a_thread_of_zenoh_keeps_its_state_from_message_to_message(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = []

    class Seen(threading.local):
        def __init__(self) -> None:
            begun.append(threading.get_ident())

    async with fleet(folder, "r1") as (world, robot):
        await world.arrivals(0.0)
        inbox, seen = world._inbox, Seen()
        append = inbox.append
        monkeypatch.setattr(inbox, "append", lambda *each: (append(*each), vars(seen)))
        for n in range(1, 20):
            robot.put(KEYS.drive("r1"), drive(n))
            await next_arrivals(world)
    assert len(begun) == len(set(begun)), "Python has forgotten a thread"


async def test_messages_on_one_key_arrive_in_order(folder: Path) -> None:
    async with fleet(folder, "r1") as (world, robot):
        count = 6
        for n in range(1, count + 1):
            robot.put(KEYS.drive("r1"), drive(n))
        arrived = await next_arrivals(world, count)
        assert arrived == [Heard(KEYS.drive("r1"), n, drive(n)) for n in range(1, count + 1)]
