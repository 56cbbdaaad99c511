"""The viewer's shell: a socket on loopback, where each connection is one request.

Rule 1: a page that reads nothing for `PATIENCE_S` is disconnected; it reconnects by itself and continues
        where it was. Until then, at most one message waits for it.
Rule 2: on a request to end, the viewer reads once more and sends the news. So users see how the run ended,
        although the launcher ends the viewer a moment later.
"""

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from dataclasses import dataclass, field
from http import HTTPStatus
from typing import Any

import h11

from clew.page.serve.channel import Channel
from clew.page.serve.site import HEAD_BYTES_MAX, Document, Site, Telling, answer, head, hosts_of, refusal
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.process.ending import asked_to_end

HOST = "127.0.0.1"
ASK_S = 10.0  # until a request is complete
PATIENCE_S = 30.0
LAST_WORD_S = 0.2  # for the last messages; the launcher waits 0.4 s after its request to end
PAGES_MAX = 64  # at once; a browser opens six at most
ASKING_MAX = 64  # at once with incomplete requests: a browser completes a request immediately
PIECE_BYTES = 65_536


@dataclass(slots=True)
class Server:
    """Answers browsers, until it is asked to end."""

    site: Site
    channels: Sequence[Channel]
    _hosts: frozenset[bytes] = frozenset()
    _pages: set[asyncio.Task[None]] = field(default_factory=set)
    _asking: dict[asyncio.Task[None], None] = field(default_factory=dict)
    """Those with an incomplete request, the oldest first."""

    async def serve(self, port: int, ready: Callable[[str], None], lifeline: int | None) -> ExitCode:
        """Serve; returns the exit code that the request to end asks for.

        Args:
            port: 0 takes a free one.
            ready: called with the address of the page.
            lifeline: as in `protocol.process.ending`.

        Raises:
            UsageError: the port is not free, or a run cannot be read.
        """
        with asked_to_end(lifeline) as asked:
            try:
                listening = await asyncio.start_server(self._meet, HOST, port)
            except OSError as error:
                raise UsageError(f"--port {port}: cannot listen on {HOST}: {error.strerror}") from error
            bound = listening.sockets[0].getsockname()[1]
            self._hosts = hosts_of(bound)
            ready(f"http://{HOST}:{bound}/")
            closing = asyncio.Event()
            watching = [asyncio.create_task(channel.follow(closing)) for channel in self.channels]
            either: list[asyncio.Future[Any]] = [asked, *watching]
            await asyncio.wait(either, return_when=asyncio.FIRST_COMPLETED)
            listening.close()
            closing.set()
            await asyncio.gather(*watching)
            await self._let_go()
            return asked.result()

    async def _let_go(self) -> None:
        """Rule 2: send the last messages to pages that read them, without waiting for the others."""
        if self._pages:
            await asyncio.wait(self._pages, timeout=LAST_WORD_S)
        for page in self._pages:
            page.cancel()
        await asyncio.gather(*self._pages, return_exceptions=True)

    async def _meet(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """One connection, from its request to its end."""
        task = asyncio.current_task()
        assert task is not None
        self._pages.add(task)
        self._asking[task] = None
        if len(self._asking) > ASKING_MAX:
            # A connection that sends nothing takes the place of another silent one only.
            next(iter(self._asking)).cancel()
        try:
            await self._converse(task, reader, writer)
            writer.close()
        except (OSError, TimeoutError):
            pass  # it has gone or reads nothing
        finally:
            self._pages.discard(task)
            self._asking.pop(task, None)
            if not writer.is_closing():
                writer.transport.abort()

    async def _converse(
        self, task: asyncio.Task[None], reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        connection = h11.Connection(h11.SERVER, HEAD_BYTES_MAX)

        async def send(event: h11.Event) -> None:
            writer.write(connection.send(event) or b"")
            await asyncio.wait_for(writer.drain(), PATIENCE_S)

        said = await self._answer(connection, reader)
        self._asking.pop(task, None)
        if len(self._pages) - len(self._asking) > PAGES_MAX:
            said = refusal(HTTPStatus.SERVICE_UNAVAILABLE)
        await send(head(said))
        if isinstance(said, Document):
            await send(h11.Data(data=said.body))
            await send(h11.EndOfMessage())
            return
        telling = asyncio.ensure_future(self._tell(said, send))
        gone = asyncio.ensure_future(_end_of(reader))
        try:
            await asyncio.wait([telling, gone], return_when=asyncio.FIRST_COMPLETED)
            if telling.done():
                await telling
                await send(h11.EndOfMessage())
        finally:
            for each in (telling, gone):
                each.cancel()
            await asyncio.gather(telling, gone, return_exceptions=True)

    async def _answer(self, connection: h11.Connection, reader: asyncio.StreamReader) -> Document | Telling:
        """The answer to the only request of a connection."""
        try:
            async with asyncio.timeout(ASK_S):
                while (event := connection.next_event()) is h11.NEED_DATA:
                    connection.receive_data(await reader.read(PIECE_BYTES))
        except h11.RemoteProtocolError:
            return refusal(HTTPStatus.BAD_REQUEST)
        if not isinstance(event, h11.Request):
            raise ConnectionResetError("gone without a word")
        return answer(event, self.site, self._hosts)

    async def _tell(self, telling: Telling, send: Callable[[h11.Event], Awaitable[None]]) -> None:
        channel = self.channels[telling.run]
        async for message in channel.messages(channel.feed.place(telling.newest_id)):
            await send(h11.Data(data=message))


async def _end_of(reader: asyncio.StreamReader) -> None:
    """Wait until the other side has gone; ignore what it still sends."""
    while await reader.read(PIECE_BYTES):
        pass
