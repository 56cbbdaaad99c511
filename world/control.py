"""Receives manual faults and the operator's stop while a run is active, at a socket in its private folder.

Rule 1 (safety): what fails while a request is served ends the world, as it does anywhere else. asyncio would
        only log it: a fence that could not be recorded would be told all the same (F3 of docs/strand.md).
Rule 2: of a client that has given up, only a stop is obeyed. A world that was frozen reads what came
        meanwhile: a fleet must not be released, or struck, after its operator was told of a failure.
"""

import asyncio
import contextlib
import logging
import os
import select
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, assert_never

import msgspec

from protocol.errors import UNREADABLE, UsageError
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
from world.record.recorder import must_write

log = logging.getLogger("world")

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
    """Accept requests while the context is open; a file in the run's folder names the socket.

    The context raises what fails in it while a request is served (rule 1).

    Raises:
        RecordingFailedError: that file cannot be written.
    """
    where, path = folder / WHERE_FILE, private / SOCKET
    path.unlink(missing_ok=True)
    world, failures = asyncio.current_task(), list[Exception]()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            await _serve(reader, writer, serves)
        except Exception as error:
            failures.append(error)  # to be raised in the world's task
            writer.close()
            if world is not None:
                world.cancel()

    try:
        server = await asyncio.start_unix_server(serve, path, limit=LINE_BYTES_MAX)
    except OSError as error:  # most likely the path is too long
        log.warning("there will be neither faults by hand nor an emergency stop: %s", error)
        yield
        return
    try:
        async with server:
            with must_write(where):
                write_whole(where, os.fsencode(path.resolve()))
            yield
    except asyncio.CancelledError:
        if failures:
            raise failures[0] from None
        raise
    finally:
        where.unlink(missing_ok=True)
        path.unlink(missing_ok=True)


async def _serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, serves: Serves) -> None:
    answer = await _answer(reader, writer, serves)
    with contextlib.suppress(OSError):  # the client may have ended
        writer.write(msgspec.json.encode(answer) + b"\n")
        await writer.drain()
        writer.close()
        await writer.wait_closed()


async def _answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, serves: Serves) -> Answer:
    try:
        async with asyncio.timeout(ANSWER_S_MAX):
            said = msgspec.json.decode(await reader.readline(), type=Request)
    except (OSError, *UNREADABLE) as error:  # a timeout is the first
        return Answer(error=str(error))
    if said != HaltRequest(stop=True) and _has_left(writer):
        return Answer(error="nobody waits for the answer any more")
    try:
        return Answer(name=_done(said, serves))
    except UsageError as error:
        return Answer(error=str(error))


def _has_left(writer: asyncio.StreamWriter) -> bool:
    """Whether the client has closed its socket (rule 2)."""
    closed = select.poll()
    closed.register(writer.get_extra_info("socket"), 0)  # that the other end is closed is told unasked
    return bool(closed.poll(0))


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
