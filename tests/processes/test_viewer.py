"""The viewer on a real socket, and `clew view` started as a user starts it."""

import asyncio
import contextlib
import json
import os
import re
import signal
import socket
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

import msgspec
import pytest

from clew.page.serve import channel as channels
from clew.page.serve import server as serving
from clew.page.serve.channel import Channel
from clew.page.serve.pages import site
from clew.page.serve.server import Server
from clew.page.serve.watch import Seen, Watch
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import AT_REST, GOOD, numbered, recorded
from tests.support.pages.views import address_of, told, view
from tests.support.processes.fleets import Fleet
from world.judge.verdict import VERDICT_FILE

LINES = numbered(AT_REST)


@pytest.fixture
def run(tmp_path: Path) -> Path:
    folder = recorded(tmp_path / "run", LINES)
    (folder / VERDICT_FILE).write_bytes(msgspec.json.encode(GOOD))
    return folder


@asynccontextmanager
async def served(run: Path) -> AsyncIterator[tuple[Channel, str, int]]:
    """A viewer of this run, and its host and port."""
    held, ours = os.pipe()
    channel = Channel(Watch(run))
    address = asyncio.get_running_loop().create_future()
    serve = asyncio.create_task(Server(site(1), [channel]).serve(0, address.set_result, held))
    try:
        await asyncio.wait([address, serve], return_when=asyncio.FIRST_COMPLETED)
        host, _, port = (await address).removeprefix("http://").rstrip("/").partition(":")
        yield channel, host, int(port)
    finally:
        os.close(ours)
        assert await asyncio.wait_for(serve, DEADLINE_S) == 128 + signal.SIGTERM
        os.close(held)


@asynccontextmanager
async def connected(host: str, port: int, said: bytes) -> AsyncIterator[asyncio.StreamReader]:
    """The server's answer to this request."""
    async with asyncio.timeout(DEADLINE_S):
        reader, writer = await asyncio.open_connection(host, port, limit=4 << 20)
        try:
            writer.write(said)
            yield reader
        finally:
            writer.close()
            with contextlib.suppress(ConnectionError):
                await writer.wait_closed()


def get(host: str, port: int) -> bytes:
    return f"GET /events/0 HTTP/1.0\r\nHost: {host}:{port}\r\n\r\n".encode()


async def listen(host: str, port: int, ended: bytes = b'"ended":true') -> list[bytes]:
    """Everything that is sent to a page, up to the message that contains this."""
    told = list[bytes]()
    async with connected(host, port, get(host, port)) as reader:
        while not told or ended not in told[-1]:
            message = await reader.readuntil(b"\n\n")
            told += re.findall(rb"^data: (.*)$", message, re.MULTILINE)
    return told


async def test_every_page_receives_the_whole_run_and_its_verdict_even_a_late_one(run: Path) -> None:
    async with served(run) as (_, host, port):
        first = await listen(host, port)
        second = await listen(host, port)
    assert first == second
    batches = [json.loads(text) for text in first]
    assert batches[0]["subject"]["scenario"]["name"] == "paper"
    assert batches[-1]["verdict"] == json.loads(msgspec.json.encode(GOOD))


async def test_a_viewer_that_is_asked_to_end_reads_once_more_and_sends_that(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(channels, "LOOK_S", 2 * DEADLINE_S)
    idle, loop, look = asyncio.Event(), asyncio.get_running_loop(), Watch.look

    def noted(watch: Watch) -> list[Seen]:
        seen = look(watch)
        if not seen:
            loop.call_soon_threadsafe(idle.set)
        return seen

    monkeypatch.setattr(Watch, "look", noted)
    (run / VERDICT_FILE).unlink()
    async with served(run) as (_, host, port):
        reader, writer = await asyncio.open_connection(host, port)
        writer.write(get(host, port))
        await reader.readuntil(b'"subject"')
        await asyncio.wait_for(idle.wait(), DEADLINE_S)
        (run / VERDICT_FILE).write_text("{}", encoding="utf-8")
    assert b'"ended":true' in await reader.read()
    writer.close()
    await writer.wait_closed()


def tell_much(channel: Channel) -> None:
    channel.feed.begin("a1")
    for _ in range(64):  # 64 MB: more than the buffers of both sockets may grow to
        channel.feed.tell(b"x" * (1 << 20))
    channel.feed.tell(b"last")


async def status(host: str, port: int) -> int:
    """The HTTP status that a new page gets now."""
    async with connected(host, port, get(host, port)) as reader:
        code = int((await reader.readline()).split()[1])
        if code != 200:
            await reader.read()  # to the end, which frees its slot
        return code


async def test_a_page_that_reads_nothing_delays_no_other(tmp_path: Path) -> None:
    async with served(tmp_path / "nowhere") as (channel, host, port):
        tell_much(channel)
        async with connected(host, port, get(host, port)) as idle:
            assert b"200" in await idle.readline()
            assert (await listen(host, port, b"last"))[-1] == b"last"


async def test_a_page_that_reads_nothing_is_dropped_and_frees_its_slot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serving, "PATIENCE_S", 0.5)
    monkeypatch.setattr(serving, "PAGES_MAX", 1)
    async with served(tmp_path / "nowhere") as (channel, host, port):
        tell_much(channel)
        async with connected(host, port, get(host, port)) as idle:
            assert b"200" in await idle.readline()
            async with asyncio.timeout(DEADLINE_S):
                while await status(host, port) != 200:  # 503: there is one slot only
                    pass


async def test_a_closed_page_frees_its_slot_even_if_nothing_happens(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(serving, "PAGES_MAX", 1)
    async with served(run) as (_, host, port):
        async with connected(host, port, get(host, port)) as page:
            assert b"200" in await page.readline()
            assert await status(host, port) == 503
        async with asyncio.timeout(DEADLINE_S):
            while await status(host, port) != 200:
                pass


async def test_a_silent_connection_keeps_nobody_out(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serving, "PAGES_MAX", 2)
    monkeypatch.setattr(serving, "ASKING_MAX", 2)
    monkeypatch.setattr(serving, "ASK_S", 2 * DEADLINE_S)
    async with served(run) as (_, host, port), AsyncExitStack() as silent:
        first, *_ = [await silent.enter_async_context(connected(host, port, b"")) for _ in range(5)]
        assert await status(host, port) == 200
        with pytest.raises((ConnectionError, asyncio.IncompleteReadError)):
            await first.readexactly(1)


async def test_a_request_that_never_ends_is_dropped(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serving, "ASK_S", 0.1)
    begun = b"GET / HTTP/1.1\r\nHost: "
    async with served(run) as (_, host, port), connected(host, port, begun) as reader:
        with pytest.raises((ConnectionError, asyncio.IncompleteReadError)):
            await reader.readexactly(1)


@pytest.mark.parametrize("said", [b"\x16\x03\x01\x02\x00\x01\r\n\r\n", b"GET / HTTP/1.1\r\n" + b"x" * 70_000])
async def test_a_client_that_speaks_no_http_gets_an_error(run: Path, said: bytes) -> None:
    async with served(run) as (_, host, port), connected(host, port, said) as reader:
        assert (await reader.readline()).startswith((b"HTTP/1.1 400", b"HTTP/1.1 431"))


def test_view_prints_only_its_address_and_ctrl_c_ends_it_with_130(run: Path, tmp_path: Path) -> None:
    with view(run, cwd=tmp_path) as viewer:
        address = address_of(viewer.stdout)
        batches = told(address)
        assert next(batches)["subject"]["run"]
        viewer.send_signal(signal.SIGINT)
        out, err = viewer.communicate(timeout=DEADLINE_S)
    assert (viewer.returncode, out, err) == (130, "", "")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run"]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["nowhere"], "no run in nowhere"),
        (["verdict.json"], "the first line is no header of a run"),
        (["--live", "verdict.json"], "the first line is no header of a run"),
        ([], "name one run, or two"),
        (["run", "run", "run"], "name one run, or two"),
        (["run", "--port", "{taken}"], "cannot listen on 127.0.0.1"),
    ],
)
def test_a_missing_or_broken_run_is_refused_in_one_line_with_exit_2(
    run: Path, tmp_path: Path, arguments: list[str], complaint: str
) -> None:
    assert run.name == "run"
    (tmp_path / VERDICT_FILE).write_text("{}", encoding="utf-8")
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        with view(*(each.replace("{taken}", port) for each in arguments), cwd=tmp_path) as viewer:
            out, err = viewer.communicate(timeout=DEADLINE_S)
    assert (viewer.returncode, out) == (2, "")
    assert err.count("\n") == 1, err
    assert complaint in err


def test_live_waits_for_a_run_and_continues_with_the_next_one(tmp_path: Path) -> None:
    with view("--live", cwd=tmp_path) as viewer:
        assert viewer.stdout is not None
        assert viewer.stderr is not None
        address = viewer.stdout.readline().strip()
        assert "waiting" in viewer.stderr.readline()
        batches = told(address)
        latest = tmp_path / "runs" / "latest"
        for name in ("first", "second"):
            folder = recorded(tmp_path / "runs" / name, LINES)
            (folder / VERDICT_FILE).write_text("{}", encoding="utf-8")
            latest.with_name("link").symlink_to(folder.name)
            latest.with_name("link").replace(latest)
            if name == "second":
                batches = told(address)  # a page that is told to restart reloads itself
            assert any(batch.get("ended") for batch in batches)
        viewer.send_signal(signal.SIGTERM)
        assert viewer.wait(DEADLINE_S) == 128 + signal.SIGTERM


def test_fleet_with_view_shows_the_run_up_to_its_verdict_and_leaves_nothing(fleet: Fleet) -> None:
    launcher = fleet.start("paper", "-n", "2", "--speed", "1", "--view", "--json")
    *_, last = told(address_of(launcher.stderr))
    outcome = fleet.end()
    assert outcome.code == 0
    assert last["ended"]
    assert last["verdict"] == json.loads(outcome.out)
    assert fleet.leftovers() == []
