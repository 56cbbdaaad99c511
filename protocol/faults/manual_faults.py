"""How `clew fault` speaks to the world of a running fleet: one request and one answer, each a line of JSON.

Rule 1: the world's socket stands in the run's private folder, so only the user can reach it. The run's own
        folder says where that is, for as long as the run goes on.
"""

import socket
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta, Struct

from protocol.errors import UsageError
from protocol.faults.rules import Rule, SomeSeconds

SOCKET = "world.sock"
WHERE_FILE = "faults.at"
LINE_BYTES_MAX = 65_536  # a rule that names each of 2000 robots twice takes half of it
ANSWER_S_MAX = 5.0  # a world answers between two ticks


class Wish(Struct, frozen=True, kw_only=True):
    """A rule that is to hold from now on."""

    rule: Rule
    for_s: SomeSeconds | None = None
    """Of a rule for messages; None: to the end of the run."""


class Answer(Struct, frozen=True, kw_only=True):
    """The name that the timeline will call the rule by, or why there is none."""

    name: Annotated[str, Meta(max_length=64)] | None = None
    error: str | None = None


def goes_on(run: Path) -> bool:
    """Whether a live run with this folder is going on: its world can be reached."""
    try:
        where = (run / WHERE_FILE).read_text(encoding="utf-8")
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(ANSWER_S_MAX)
            connection.connect(where)
    except OSError:
        return False
    return True


def wish(run: Path, wished: Wish) -> str:
    """Tell the world of a run; returns the name of the rule.

    Raises:
        UsageError: the run is over, or the world does not do it.
    """
    try:
        where = (run / WHERE_FILE).read_text(encoding="utf-8")
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(ANSWER_S_MAX)
            connection.connect(where)
            connection.sendall(msgspec.json.encode(wished) + b"\n")
            with connection.makefile("rb") as file:
                answer = msgspec.json.decode(file.readline(LINE_BYTES_MAX), type=Answer)
    except FileNotFoundError as error:
        raise UsageError(f"{run}: no run goes on there") from error
    except TimeoutError as error:
        raise UsageError(f"{run}: its world does not answer within {ANSWER_S_MAX:g} s") from error
    except (OSError, msgspec.MsgspecError) as error:
        raise UsageError(f"{run}: its world has gone: the run is over") from error
    if answer.name is None:
        raise UsageError(answer.error or f"{run}: its world refuses, and does not say why")
    return answer.name
