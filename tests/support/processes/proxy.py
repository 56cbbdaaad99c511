"""A proxy for tests: it damages and delays the bytes that it forwards, as its seed decides.

Rule 1: each direction of each connection has its own random stream. Each piece takes the same number of draws
        from it, with any faults: so equal pieces suffer equal faults.
Rule 2: pieces keep their order, as in TCP: a delayed piece delays all pieces behind it.
Rule 3: a connection ends in both directions when either side closes it or the proxy resets it.
"""

import asyncio
import contextlib
import socket
import struct
import threading
from collections import Counter
from collections.abc import AsyncIterator, Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from random import Random

from protocol.wire.codec import SEAL_BYTES, UINT32

PIECE_BYTES_MAX = 4096  # per read: holds several messages of a fleet
PIECES_MAX = 256  # in flight: then the sender has to wait, as for a full TCP window
FRAME, MESSAGE_MASK = 0x05, 0x1F  # in a batch's first byte: the kind of its transport message
LINGER_NOT = struct.pack("ii", 1, 0)  # closing sends a reset


class Way(StrEnum):
    """The direction of bytes."""

    UP = "up"
    """To the server."""
    DOWN = "down"


@dataclass(frozen=True, slots=True, kw_only=True)
class Faults:
    """The faults of one direction. Probabilities are per piece: the bytes of one read."""

    flip_probability: float = 0.0
    """One of its bits is flipped."""
    only_seals: bool = False
    """Only checksums of our messages are flipped, where a piece ends with one; Zenoh's own bytes pass."""
    truncate_probability: float = 0.0
    """The piece loses its end; the next piece follows normally."""
    reset_probability: float = 0.0
    """The piece and its connection are lost."""
    delay_s: float = 0.0
    jitter_s: float = 0.0
    """At most this much is added to the delay."""
    forged: bytes = b""
    """Appended to a Zenoh frame that ends the piece, as if the sender had sent it."""
    frames_lost: bool = False
    """Of Zenoh's bytes, only handshakes and signs of life pass, as on a link that was half opened."""

    def __post_init__(self) -> None:
        for name in ("flip_probability", "truncate_probability", "reset_probability"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ValueError(f"{name} must be within 0 and 1, got {getattr(self, name)}")


@dataclass(frozen=True, slots=True)
class Fate:
    """What happens to one piece."""

    piece: bytes
    delay_s: float
    struck: tuple[str, ...]
    """`flipped`, `truncated`, `reset`."""


def lengthened(piece: bytes, by: bytes) -> bytes:
    """Zenoh's bytes, with these appended to the last batch if that is a complete frame."""
    if (begin := begin_of_last_frame(piece)) is None:
        return piece
    batch = piece[begin + 2 :]
    return piece[:begin] + (len(batch) + len(by)).to_bytes(2, "little") + batch + by


def begin_of_last_frame(piece: bytes) -> int | None:
    """Where the last of Zenoh's batches begins; None if that is no complete frame."""
    begin, end = 0, 0
    while end < len(piece):
        begin, end = end, end + 2 + int.from_bytes(piece[end : end + 2], "little")
    is_frame = end == len(piece) > begin + 2 and piece[begin + 2] & MESSAGE_MASK == FRAME
    return begin if is_frame else None


def ends_with_seal(piece: bytes) -> bool:
    """Whether the last bytes are the checksum of a message of ours."""
    begin = begin_of_last_frame(piece)
    return begin is not None and piece[begin + 2 :][-SEAL_BYTES:].startswith(bytes([UINT32]))


def without_frames(piece: bytes) -> bytes:
    """Zenoh's bytes without its frames, which carry messages and declarations; it has whole batches."""
    kept, begin = b"", 0
    while begin < len(piece):
        end = begin + 2 + int.from_bytes(piece[begin : begin + 2], "little")
        if piece[begin + 2] & MESSAGE_MASK != FRAME:
            kept += piece[begin:end]
        begin = end
    return kept


def fate(piece: bytes, faults: Faults, random: Random) -> Fate:
    """What happens to a piece that is not empty."""
    flips = random.random() < faults.flip_probability
    bit = random.randrange(8 * len(piece))
    cuts = random.random() < faults.truncate_probability
    kept_bytes = random.randrange(len(piece))
    resets = random.random() < faults.reset_probability
    delay_s = faults.delay_s + random.uniform(0.0, faults.jitter_s)
    if faults.only_seals:
        flips = flips and ends_with_seal(piece)
        bit = 8 * (len(piece) - SEAL_BYTES) + bit % (8 * SEAL_BYTES)
    piece = lengthened(piece, faults.forged)
    if faults.frames_lost:
        piece = without_frames(piece)
    if flips:
        damaged = bytearray(piece)
        damaged[bit // 8] ^= 1 << bit % 8
        piece = bytes(damaged)
    if cuts:
        piece = piece[:kept_bytes]
    effects = {"flipped": flips, "truncated": cuts, "reset": resets}
    return Fate(piece, delay_s, tuple(name for name, strikes in effects.items() if strikes))


class Proxy:
    """Made by `proxy`. Faults may be changed at any time; they apply to everything read afterwards."""

    def __init__(self, server: int | str, seed: int) -> None:
        self.faults = {way: Faults() for way in Way}
        self.counts: Counter[str] = Counter()
        """Effects by name, and `connected`."""
        self._server = server
        self._seed = seed

    async def serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Forward the bytes of one client and the server while both are connected."""
        number = self.counts["connected"]
        self.counts["connected"] += 1
        try:
            server_reader, server_writer = await _connected(self._server)
        except OSError:
            writer.close()
            return
        connection = _Connection((writer, server_writer))
        pumps = [
            asyncio.ensure_future(self._pump(connection, number, way, *streams))
            for way, streams in ((Way.UP, (reader, server_writer)), (Way.DOWN, (server_reader, writer)))
        ]
        try:
            await asyncio.wait(pumps, return_when=asyncio.FIRST_COMPLETED)
        finally:
            connection.end()
            for pump in pumps:
                pump.cancel()
            await asyncio.gather(*pumps, return_exceptions=True)

    async def _pump(
        self,
        connection: "_Connection",
        number: int,
        way: Way,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
    ) -> None:
        """Forward one direction of a connection until it ends."""
        pieces: asyncio.Queue[tuple[float, bytes] | None] = asyncio.Queue(PIECES_MAX)
        writing = asyncio.ensure_future(_write(pieces, writer))
        random = Random(f"{self._seed}/{number}/{way}")
        try:
            with contextlib.suppress(ConnectionError):
                while piece := await reader.read(PIECE_BYTES_MAX):
                    suffered = fate(piece, self.faults[way], random)
                    self.counts.update(suffered.struck)
                    if "reset" in suffered.struck:
                        connection.reset()
                        return
                    due_s = asyncio.get_running_loop().time() + suffered.delay_s
                    await pieces.put((due_s, suffered.piece))
            await pieces.put(None)
            await writing
        finally:
            writing.cancel()
            await asyncio.gather(writing, return_exceptions=True)


async def _write(pieces: asyncio.Queue[tuple[float, bytes] | None], writer: asyncio.StreamWriter) -> None:
    loop = asyncio.get_running_loop()
    with contextlib.suppress(ConnectionError):
        while (due := await pieces.get()) is not None:
            due_s, piece = due
            await asyncio.sleep(due_s - loop.time())
            writer.write(piece)
            await writer.drain()


async def _connected(server: int | str) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    if isinstance(server, str):
        return await asyncio.open_unix_connection(server)
    return await asyncio.open_connection("127.0.0.1", server)


@dataclass(eq=False, slots=True)
class _Connection:
    writers: tuple[asyncio.StreamWriter, asyncio.StreamWriter]
    _is_reset: bool = field(default=False)

    def reset(self) -> None:
        self._is_reset = True
        for writer in self.writers:
            writer.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER_NOT)
            writer.transport.abort()

    def end(self) -> None:
        if not self._is_reset:
            for writer in self.writers:
                writer.close()


@contextlib.asynccontextmanager
async def proxy(server: int | str, *, seed: int = 1) -> AsyncIterator[tuple[Proxy, int]]:
    """A loopback proxy for the server at this port or Unix socket, and the proxy's port.

    All ends with the context.
    """
    serving: set[asyncio.Task[None]] = set()
    between = Proxy(server, seed)

    def accept(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        task = asyncio.ensure_future(between.serve(reader, writer))
        serving.add(task)
        task.add_done_callback(serving.discard)

    listening = await asyncio.start_server(accept, "127.0.0.1", 0)
    try:
        yield between, listening.sockets[0].getsockname()[1]
    finally:
        listening.close()
        for task in list(serving):
            task.cancel()
        await asyncio.gather(*serving, return_exceptions=True)
        await listening.wait_closed()


@contextlib.contextmanager
def proxy_aside(server: int | str, *, seed: int) -> Iterator[tuple[Proxy, int]]:
    """The same in its own thread, for tests that block. They may change only its faults."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    context = proxy(server, seed=seed)
    try:
        both = asyncio.run_coroutine_threadsafe(context.__aenter__(), loop).result()
        try:
            yield both
        finally:
            asyncio.run_coroutine_threadsafe(context.__aexit__(None, None, None), loop).result()
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()
