"""Receives manual faults and the operator's stop while a run is active, at a socket in its private folder."""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, assert_never

import msgspec

from protocol.errors import UsageError
from protocol.faults.manual_faults import (
    ANSWER_S_MAX,
    LINE_BYTES_MAX,
    SOCKET,
    WHERE_FILE,
    Answer,
    EndRequest,
    FaultRequest,
    GoRequest,
    HaltRequest,
    Request,
)
from protocol.faults.rules import Rule
from protocol.files.writing import write_whole

Add = Callable[[Rule, float | None], str]
"""Applies a rule for a time; returns its name, or raises `UsageError`."""


Go = Callable[[float], str]
"""Lets a held run go on for so long; returns its time, or raises `UsageError`."""

End = Callable[[str], None]
"""Ends the rule with this name, or raises `UsageError`."""


class Halt(Protocol):
    """Stops the fleet, or releases it; returns what it is in the timeline, or raises `UsageError`."""

    def __call__(self, *, stop: bool) -> str:
        """Stop the fleet, or release it."""
        ...


@dataclass(frozen=True, slots=True)
class Serves:
    """What serves each kind of request."""

    add: Add
    end: End
    halt: Halt
    go: Go


@contextlib.asynccontextmanager
async def heard(private: Path, folder: Path, serves: Serves) -> AsyncIterator[None]:
    """Accept requests while the context is open; a file in the run's folder names the socket."""
    where, path = folder / WHERE_FILE, private / SOCKET
    path.unlink(missing_ok=True)
    try:
        server = await asyncio.start_unix_server(
            lambda reader, writer: _serve(reader, writer, serves), path, limit=LINE_BYTES_MAX
        )
    except OSError:  # the path is too long: the run continues without manual faults
        yield
        return
    try:
        async with server:
            write_whole(where, os.fsencode(path.resolve()))
            yield
    finally:
        where.unlink(missing_ok=True)
        path.unlink(missing_ok=True)


async def _serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, serves: Serves) -> None:
    with contextlib.suppress(OSError):  # the client may have ended
        try:
            async with asyncio.timeout(ANSWER_S_MAX):
                said = msgspec.json.decode(await reader.readline(), type=Request)
            answer = Answer(name=_done(said, serves))
        except (UsageError, TimeoutError, ValueError) as error:  # msgspec's are ValueErrors
            answer = Answer(error=str(error))
        writer.write(msgspec.json.encode(answer) + b"\n")
        await writer.drain()
        writer.close()
        await writer.wait_closed()


def _done(said: Request, serves: Serves) -> str:
    match said:
        case FaultRequest(rule=rule, for_s=for_s):
            return serves.add(rule, for_s)
        case EndRequest(name=name):
            serves.end(name)
            return name
        case HaltRequest(stop=stop):
            return serves.halt(stop=stop)
        case GoRequest(for_s=for_s):
            return serves.go(for_s)
        case _:
            assert_never(said)
