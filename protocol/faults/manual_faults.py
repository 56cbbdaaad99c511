"""The protocol between `clew fault` and the world of a run: one request, one answer, each a JSON line.

The operator's stop takes the same way: it needs a world that can be reached, and its user's right to it.

Rule 1: the world's socket is in the run's private folder, so only the user can reach it. A file in the run's
        folder names the socket while the run is active.
Rule 2: a world that was killed is started again: a request waits for it. An emergency stop must not be lost.
        So one is asked again if the world ends before it answers: asked twice, it stops the fleet once.
        Nothing else is, since nobody knows whether it was done.
"""

import os
import socket
import time
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from protocol.errors import UsageError, no_run_in
from protocol.faults.rules import Name, Rule, SomeSeconds
from protocol.files.opening import read_bytes

SOCKET = "world.sock"
WHERE_FILE = "faults.at"
LINE_BYTES_MAX = 65_536  # a rule that names each of 2000 robots twice takes half of this
ANSWER_S_MAX = 5.0  # a world answers between two ticks
AGAIN_S_MAX = 10.0  # to start a world again takes a second, and longer on a slow machine
AGAIN_EVERY_S = 0.1


class FaultRequest(Struct, frozen=True, kw_only=True, tag="fault"):
    """A rule to apply from now on."""

    rule: Rule
    for_s: SomeSeconds | None = None
    """How long a rule for messages is active; None: to the end of the run."""


class EndRequest(Struct, frozen=True, kw_only=True, tag="end"):
    """End a rule for messages that was given before."""

    name: Name


class HaltRequest(Struct, frozen=True, kw_only=True, tag="halt"):
    """Stop the fleet, or release it, as its operator."""

    stop: bool


class GoRequest(Struct, frozen=True, kw_only=True, tag="go"):
    """Let the simulated time of a held run go on for this long from now."""

    for_s: SomeSeconds


Request = FaultRequest | EndRequest | HaltRequest | GoRequest


class Answer(Struct, frozen=True, kw_only=True):
    """The name of the rule in the timeline or of the fence, or the reason for a refusal."""

    name: Annotated[str, Meta(max_length=64)] | None = None
    error: str | None = None


def is_running(run: Path) -> bool:
    """Whether a live run with this folder is active: its world can be reached."""
    try:
        where = os.fsdecode(read_bytes(run / WHERE_FILE, LINE_BYTES_MAX))
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(ANSWER_S_MAX)
            connection.connect(where)
    except (OSError, ValueError):  # none goes on there, or its file is none of ours
        return False
    return True


def request_fault(run: Path, request: Request) -> str:
    """Ask the world of a run to do something; returns the name of what it has done.

    Raises:
        UsageError: the run is over, or the world refuses the request.
    """
    try:
        answer = _answer(run, request)
    except (FileNotFoundError, NotADirectoryError) as error:
        if not run.exists():
            raise no_run_in(run) from error
        raise UsageError(f"{run}: no run goes on there: it is over or still starting") from error
    except TimeoutError as error:
        raise UsageError(f"{run}: its world does not answer within {ANSWER_S_MAX:g} s") from error
    except (OSError, ValueError) as error:  # msgspec's are ValueErrors
        raise UsageError(
            f"{run}: its world has ended before it answered; ask again if the run goes on"
        ) from error
    if answer.name is None:
        raise UsageError(answer.error or f"{run}: its world refuses without a reason")
    return answer.name


def _answer(run: Path, request: Request) -> Answer:
    """Rule 2: as long as there is a file that names the socket, there will be a world."""
    ends_with = ConnectionError if request == HaltRequest(stop=True) else ConnectionRefusedError
    until_s = time.monotonic() + AGAIN_S_MAX
    while True:
        try:
            return _asked_once(run, request)
        except ends_with:
            if time.monotonic() >= until_s:
                raise
        time.sleep(AGAIN_EVERY_S)


def _asked_once(run: Path, request: Request) -> Answer:
    where = os.fsdecode(read_bytes(run / WHERE_FILE, LINE_BYTES_MAX))
    with socket.socket(socket.AF_UNIX) as connection:
        connection.settimeout(ANSWER_S_MAX)
        try:
            connection.connect(where)
        except FileNotFoundError:
            if Path(where).parent.exists():  # a world that starts is putting its socket there
                raise ConnectionRefusedError from None
            raise
        connection.sendall(msgspec.json.encode(request) + b"\n")
        with connection.makefile("rb") as file:
            said = file.readline(LINE_BYTES_MAX)
    if not said.endswith(b"\n"):
        raise ConnectionResetError
    return msgspec.json.decode(said, type=Answer)
