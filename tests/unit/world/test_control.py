"""Requests to the world of a run: manual faults, the operator's stop and release."""

import asyncio
import socket
from pathlib import Path

import msgspec
import pytest

from protocol.errors import UsageError
from protocol.faults.manual_faults import (
    AGAIN_EVERY_S,
    SOCKET,
    WHERE_FILE,
    EndRequest,
    FaultRequest,
    GoRequest,
    HaltRequest,
    Request,
    request_fault,
)
from protocol.faults.rules import Drop, Kill, Rule
from tests.support.deadline import DEADLINE_S
from world.control import Serves, heard
from world.record.recorder import RecordingFailedError


def no_halt(*, stop: bool) -> str:
    raise UsageError(f"a test without a fence was asked: stop={stop}")


def nothing_to_end(name: str) -> None:
    raise UsageError(f"no rule {name} for messages is active")


def given_1(_rule: Rule, _for_s: float | None) -> str:
    return "given-1"


def no_go(for_s: float) -> str:
    raise AssertionError(f"asked to go on for {for_s}")


def no_rule(rule: Rule, _for_s: float | None) -> str:
    raise AssertionError(f"given {rule}")


def no_end(name: str) -> None:
    raise AssertionError(f"asked to end {name}")


async def ask(run: Path, request: Request) -> str:
    return await asyncio.to_thread(request_fault, run, request)


async def test_a_fault_request_is_answered_with_the_rules_name_or_the_reason_of_refusal(
    tmp_path: Path,
) -> None:
    asked: list[tuple[Rule, float | None]] = []
    ended: list[str] = []

    def add(rule: Rule, for_s: float | None) -> str:
        asked.append((rule, for_s))
        if isinstance(rule, Kill):
            raise UsageError("not him")
        return "given-7"

    async with heard(tmp_path, tmp_path, Serves(add, ended.append, no_halt, no_go)):
        assert await ask(tmp_path, FaultRequest(rule=Drop(probability=0.5), for_s=5.0)) == "given-7"
        with pytest.raises(UsageError, match="not him"):
            await ask(tmp_path, FaultRequest(rule=Kill(target="r3")))
        assert await ask(tmp_path, EndRequest(name="given-7")) == "given-7"
    assert asked == [(Drop(probability=0.5), 5.0), (Kill(target="r3"), None)]
    assert ended == ["given-7"]
    with pytest.raises(UsageError, match="no run goes on there"):
        await ask(tmp_path, FaultRequest(rule=Drop()))
    with pytest.raises(UsageError, match=r"no run in .*nowhere: there is no such folder"):
        await ask(tmp_path / "nowhere", FaultRequest(rule=Drop()))
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match="file: no run goes on there"):
        await ask(tmp_path / "file", FaultRequest(rule=Drop()))


async def test_the_operators_stop_and_release_are_answered_with_the_fence_or_the_reason_of_refusal(
    tmp_path: Path,
) -> None:
    def halt(*, stop: bool) -> str:
        if stop:
            return "30000"
        raise UsageError("it does not stand")

    async with heard(tmp_path, tmp_path, Serves(given_1, nothing_to_end, halt, no_go)):
        assert await ask(tmp_path, HaltRequest(stop=True)) == "30000"
        with pytest.raises(UsageError, match="it does not stand"):
            await ask(tmp_path, HaltRequest(stop=False))


async def test_a_stop_waits_for_a_world_that_was_killed_and_is_started_again(tmp_path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(str(tmp_path / SOCKET))
    (tmp_path / WHERE_FILE).write_text(str(tmp_path / SOCKET))
    asking = asyncio.create_task(ask(tmp_path, HaltRequest(stop=True)))
    assert await asyncio.wait([asking], timeout=3.0 * AGAIN_EVERY_S) == (set(), {asking})
    async with heard(tmp_path, tmp_path, Serves(given_1, nothing_to_end, lambda *, stop: f"{stop}", no_go)):
        assert await asking == "True"


@pytest.mark.parametrize("request_", [HaltRequest(stop=False), FaultRequest(rule=Drop())])
async def test_only_a_stop_is_asked_again_if_the_world_is_killed_before_it_answers(
    tmp_path: Path, request_: Request
) -> None:
    (tmp_path / WHERE_FILE).write_text(str(tmp_path / SOCKET))
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(str(tmp_path / SOCKET))
        killed.listen()
        asking = [asyncio.create_task(ask(tmp_path, each)) for each in (HaltRequest(stop=True), request_)]
        for _ in asking:
            connection, _ = await asyncio.to_thread(killed.accept)
            connection.recv(100)
            connection.close()
    (tmp_path / SOCKET).unlink()  # as a world that starts does, before its own socket is there
    with pytest.raises(UsageError, match="ask again if the run goes on"):
        await asking[1]
    async with heard(tmp_path, tmp_path, Serves(no_rule, no_end, lambda *, stop: f"{stop}", no_go)):
        assert await asking[0] == "True"


async def test_what_fails_while_a_request_is_served_ends_the_world(tmp_path: Path) -> None:
    def halt(*, stop: bool) -> str:
        raise RecordingFailedError(f"cannot record a fence, stop={stop}")

    async def world() -> None:
        async with heard(tmp_path, tmp_path, Serves(given_1, nothing_to_end, halt, no_go)):
            with pytest.raises(UsageError, match="its world has ended"):
                await ask(tmp_path, HaltRequest(stop=True))
            await asyncio.sleep(DEADLINE_S)

    with pytest.raises(RecordingFailedError, match="stop=True"):
        await world()


async def test_a_run_that_cannot_be_asked_says_that_there_is_no_emergency_stop(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    private = tmp_path / "a path that is too long for a socket".ljust(120, ".")
    private.mkdir()
    async with heard(private, tmp_path, Serves(no_rule, no_end, no_halt, no_go)):
        assert not (tmp_path / WHERE_FILE).exists()
    assert "neither faults by hand nor an emergency stop" in caplog.text


async def test_a_held_run_is_asked_to_go_on_and_answers_with_its_time(tmp_path: Path) -> None:
    async with heard(
        tmp_path, tmp_path, Serves(given_1, nothing_to_end, no_halt, lambda for_s: f"{1.0 + for_s}")
    ):
        assert await ask(tmp_path, GoRequest(for_s=0.5)) == "1.5"


async def test_a_fault_request_to_a_killed_world_reports_the_end_of_the_run(tmp_path: Path) -> None:
    (tmp_path / WHERE_FILE).write_text(str(tmp_path / "gone" / SOCKET))
    with pytest.raises(UsageError, match="run"):
        await ask(tmp_path, FaultRequest(rule=Drop()))


async def test_of_clients_that_have_given_up_only_a_stop_is_obeyed(tmp_path: Path) -> None:
    asked: list[bool] = []

    def halt(*, stop: bool) -> str:
        asked.append(stop)
        return f"{stop}"

    async with heard(tmp_path, tmp_path, Serves(no_rule, no_end, halt, no_go)):
        given_up: list[Request] = [HaltRequest(stop=False), FaultRequest(rule=Drop()), EndRequest(name="a")]
        for request in (*given_up, GoRequest(for_s=1.0), HaltRequest(stop=True)):
            with socket.socket(socket.AF_UNIX) as client:  # this loop is as a frozen world meanwhile
                client.connect(str(tmp_path / SOCKET))
                client.sendall(msgspec.json.encode(request) + b"\n")
        assert await ask(tmp_path, HaltRequest(stop=False)) == "False"
    assert asked == [True, False]


@pytest.mark.parametrize("said", [b"garbage", b'{"type":"halt","stop":true,"more":' + b"[" * 9999])
async def test_an_invalid_request_is_refused_and_the_next_one_is_served(tmp_path: Path, said: bytes) -> None:
    async with heard(tmp_path, tmp_path, Serves(given_1, nothing_to_end, no_halt, no_go)):
        reader, writer = await asyncio.open_unix_connection((tmp_path / WHERE_FILE).read_text())
        writer.write(said + b"\n")
        assert b'"error":"' in await reader.readline()
        writer.close()
        assert await ask(tmp_path, FaultRequest(rule=Drop())) == "given-1"


async def test_a_folder_that_takes_no_file_ends_the_run_in_one_line(tmp_path: Path) -> None:
    serves = Serves(given_1, nothing_to_end, no_halt, no_go)
    with pytest.raises(RecordingFailedError, match=r"cannot write .*: No such file"):
        async with heard(tmp_path, tmp_path / "full", serves):
            pass
