"""The fleet's router as a process: it reports when it is ready, ends on request, takes no used address."""

import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from protocol.errors import UsageError
from protocol.network.session import read_session, write_sessions
from protocol.network.zenoh_transport import open_transport
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
    assert errors.startswith(f"router: cannot listen at {tcp_endpoint}: ")
    assert "Address already in use" in errors
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


def certify(folder: Path, name: str) -> tuple[Path, Path]:
    """A key, and a certificate for this machine that it has signed itself."""
    key, certificate = folder / f"{name}.key", folder / f"{name}.pem"
    told = f"-subj /CN={name} -addext subjectAltName=IP:127.0.0.1 -addext basicConstraints=CA:FALSE"
    made = f"-newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -keyout {key} -out {certificate} -days 2"
    subprocess.run(["openssl", "req", "-x509", *told.split(), *made.split()], check=True, capture_output=True)
    return key, certificate


@pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the certificates")
async def test_over_tls_a_process_talks_to_the_router_with_the_right_certificate_alone(
    folder: Path, tcp_endpoint: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    address, plain = tcp_endpoint.replace("tcp/", "tls/"), tcp_endpoint
    key, certificate = certify(folder, "router")
    _, another = certify(folder, "another")
    settings = f"listen_private_key_file={key};listen_certificate_file={certificate}"
    endpoint = f"{address}#{settings};root_ca_certificate_file={certificate}"
    write_sessions(folder, fleet=KEYS.fleet, run=KEYS.run, robots=3, endpoints=[endpoint])
    with router(folder):
        async with fleet(folder, "r1") as (world, robot):
            robot.put(KEYS.drive("r1"), drive(1))
            await next_arrivals(world)
        monkeypatch.setattr("protocol.network.zenoh_transport.connect_s", lambda _: 0.3)
        for wrong in (f"{address}#root_ca_certificate_file={another}", address, plain):
            session = replace(read_session(folder / "r1.json"), endpoints=(wrong,))
            with (
                pytest.raises(UsageError, match="no router answers"),
                open_transport(session, hear=[], answer=[], alive=None, watch=[]),
            ):
                pass
