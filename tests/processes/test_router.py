"""The fleet's router as a process: it reports when it is ready, ends on request, takes no used address."""

import signal
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from protocol.process.asked import EXIT_CODES
from tests.support.deadline import DEADLINE_S
from tests.support.processes.wire import KEYS, drive, fleet, next_arrivals, python, router, session_folder


@pytest.fixture
def folder() -> Iterator[Path]:
    with session_folder() as folder:
        yield folder


@pytest.fixture
def tcp_endpoint() -> str:
    """A port that was free just now."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"tcp/127.0.0.1:{server.getsockname()[1]}"


def run_router(folder: Path, *options: str) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a router that is expected to end by itself."""
    with python("-m", "protocol", "--sessions", str(folder), *options) as process:
        output, errors = process.communicate(timeout=DEADLINE_S)
        return process.returncode, output, errors


@pytest.mark.parametrize(("number", "code"), EXIT_CODES.items())
def test_a_signal_ends_it_silently_and_leaves_no_socket(
    folder: Path, number: signal.Signals, code: int
) -> None:
    files = sorted(folder.iterdir())
    with router(folder, lifeline=False) as process:
        assert (folder / "router.sock").is_socket()
        process.send_signal(number)
        output, errors = process.communicate(timeout=DEADLINE_S)
    assert (process.returncode, output, errors) == (code, "", "")
    assert sorted(folder.iterdir()) == files


async def test_on_a_lifeline_it_ends_with_the_process_at_the_other_end(folder: Path) -> None:
    with router(folder) as process:
        assert process.stdin is not None
        process.stdin.write("words do not end it\n")
        process.stdin.flush()
        async with fleet(folder, "r1"):
            assert process.poll() is None
        process.stdin.close()
        assert process.wait(DEADLINE_S) == 143


async def test_without_a_lifeline_the_end_of_its_input_is_ignored(folder: Path) -> None:
    with router(folder, lifeline=False) as process:
        assert process.stdin is not None
        process.stdin.close()
        async with fleet(folder, "r1") as (world, robot):
            robot.put(KEYS.drive("r1"), drive(1))
            await next_arrivals(world)
        assert process.poll() is None


async def test_a_second_router_at_the_same_address_is_refused_and_the_first_continues(folder: Path) -> None:
    with router(folder):
        code, output, errors = run_router(folder)
        assert (code, output) == (2, "")
        assert errors.startswith("router: cannot listen at unixsock-stream/")
        assert errors.count("\n") == 1
        async with fleet(folder, "r1") as (world, robot):
            robot.put(KEYS.drive("r1"), drive(1))
            await next_arrivals(world)


async def test_the_socket_of_a_killed_router_is_taken_over(folder: Path) -> None:
    with router(folder) as killed:
        killed.kill()
        killed.wait(DEADLINE_S)
    assert (folder / "router.sock").is_socket()
    with router(folder):
        async with fleet(folder, "r1") as (world, robot):
            robot.put(KEYS.drive("r1"), drive(1))
            await next_arrivals(world)


def test_it_listens_at_the_given_endpoint_and_prints_it(folder: Path, tcp_endpoint: str) -> None:
    with python("-m", "protocol", "--sessions", str(folder), "--listen", tcp_endpoint) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == f"ready {tcp_endpoint}\n"
        code, output, errors = run_router(folder, "--listen", tcp_endpoint)
    assert (code, output) == (2, "")
    assert errors.startswith(f"router: cannot listen at {tcp_endpoint}, is it taken? ")
    assert "/root/" not in errors
    assert errors.count("\n") == 1


@pytest.mark.parametrize("endpoint", ["nowhere", "carrier-pigeon/x", "unixsock-stream/" + "/x" * 60])
def test_a_bad_endpoint_is_reported_in_one_line_with_code_2(folder: Path, endpoint: str) -> None:
    code, output, errors = run_router(folder, "--listen", endpoint)
    assert (code, output, errors.count("\n")) == (2, "", 1)


def test_a_folder_without_sessions_is_reported_in_one_line_with_code_2(tmp_path: Path) -> None:
    code, output, errors = run_router(tmp_path)
    assert (code, output) == (2, "")
    assert errors.startswith("router: no session in ")
    assert errors.count("\n") == 1


def test_help_describes_the_router() -> None:
    with python("-m", "protocol", "--help") as process:
        output, _ = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 0
    assert "The fleet's Zenoh router" in output
