"""Receives manual faults while a run is active, at a socket in its private folder. A shell."""

import asyncio
import contextlib
import os
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import msgspec

from protocol.errors import UsageError
from protocol.faults.manual_faults import (
    ANSWER_S_MAX,
    LINE_BYTES_MAX,
    SOCKET,
    WHERE_FILE,
    Answer,
    FaultRequest,
)
from protocol.faults.rules import Rule
from protocol.files.writing import write_whole

Add = Callable[[Rule, float | None], str]
"""Applies a rule for a time; returns its name, or raises `UsageError`."""


@contextlib.asynccontextmanager
async def heard(private: Path, folder: Path, add: Add) -> AsyncIterator[None]:
    """Accept fault requests while the context is open; a file in the run's folder names the socket."""
    where, path = folder / WHERE_FILE, private / SOCKET
    path.unlink(missing_ok=True)
    try:
        server = await asyncio.start_unix_server(
            lambda reader, writer: _serve(reader, writer, add), path, limit=LINE_BYTES_MAX
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


async def _serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, add: Add) -> None:
    with contextlib.suppress(OSError):  # the client may have ended
        try:
            async with asyncio.timeout(ANSWER_S_MAX):
                said = msgspec.json.decode(await reader.readline(), type=FaultRequest)
            answer = Answer(name=add(said.rule, said.for_s))
        except (UsageError, TimeoutError, ValueError) as error:  # msgspec's are ValueErrors
            answer = Answer(error=str(error))
        writer.write(msgspec.json.encode(answer) + b"\n")
        await writer.drain()
        writer.close()
        await writer.wait_closed()
