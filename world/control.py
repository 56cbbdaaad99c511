"""Receives manual faults and the operator's stop while a run is active, at a socket in its private folder."""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Callable
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
    HaltRequest,
    Request,
)
from protocol.faults.rules import Rule
from protocol.files.writing import write_whole

Add = Callable[[Rule, float | None], str]
"""Applies a rule for a time; returns its name, or raises `UsageError`."""


End = Callable[[str], None]
"""Ends the rule with this name, or raises `UsageError`."""


class Halt(Protocol):
    """Stops the fleet, or releases it; returns what it is in the timeline, or raises `UsageError`."""

    def __call__(self, *, stop: bool) -> str:
        """Stop the fleet, or release it."""
        ...


@contextlib.asynccontextmanager
async def heard(private: Path, folder: Path, add: Add, end: End, halt: Halt) -> AsyncIterator[None]:
    """Accept requests while the context is open; a file in the run's folder names the socket."""
    where, path = folder / WHERE_FILE, private / SOCKET
    path.unlink(missing_ok=True)
    try:
        server = await asyncio.start_unix_server(
            lambda reader, writer: _serve(reader, writer, add, end, halt), path, limit=LINE_BYTES_MAX
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


async def _serve(
    reader: asyncio.StreamReader, writer: asyncio.StreamWriter, add: Add, end: End, halt: Halt
) -> None:
    with contextlib.suppress(OSError):  # the client may have ended
        try:
            async with asyncio.timeout(ANSWER_S_MAX):
                said = msgspec.json.decode(await reader.readline(), type=Request)
            answer = Answer(name=_done(said, add, end, halt))
        except (UsageError, TimeoutError, ValueError) as error:  # msgspec's are ValueErrors
            answer = Answer(error=str(error))
        writer.write(msgspec.json.encode(answer) + b"\n")
        await writer.drain()
        writer.close()
        await writer.wait_closed()


def _done(said: Request, add: Add, end: End, halt: Halt) -> str:
    match said:
        case FaultRequest(rule=rule, for_s=for_s):
            return add(rule, for_s)
        case EndRequest(name=name):
            end(name)
            return name
        case HaltRequest(stop=stop):
            return halt(stop=stop)
        case _:
            assert_never(said)
