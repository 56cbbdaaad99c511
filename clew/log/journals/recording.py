"""A robot's journal as it is read; its writer is `agents.process.journal`."""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import get_args

import msgpack
import msgspec

from agents.events import Event
from agents.process.journal import FULL, GZIP, SCHEMA, Decision, End, Head, Input, Written
from protocol.errors import UsageError
from protocol.files.opening import open_regular
from protocol.keys import robot_name
from protocol.wire.codec import REASON_LENGTH_MAX

PACKED = b"\x1f\x8b"  # how a gzip stream begins; a msgpack array does not
PIECE_BYTES = 1 << 14  # read at a time; gzip packs 1000 bytes into one at most
RECORD_BYTES_MAX = 1 << 24  # 100 times a scan of 7200 rays and the decision on it

_EVENTS: dict[str, type] = {kind.__name__: kind for kind in get_args(Event)}
_BEGINNINGS = (b"\x96\xa2in\xcb", b"\x93\xa3out", b"\x92\xa3end")
"""The first bytes of records: the number of items and the tag; for an input also the float's marker."""


@dataclass(frozen=True, slots=True)
class Turn:
    """An input and its recorded decision, which is None if the journal ends before it."""

    input: Input
    decision: Decision | None

    @property
    def event(self) -> Event:
        """The event that was given to the core."""
        event: Event = self.input.event
        return event


class NoRecordError(UsageError):
    """A journal without a whole record: its writer was killed as it began, or its disk has lost the rest."""


class Recording:
    """A journal as it is read, turn by turn. Its flaw is known only after the last turn."""

    def __init__(self, path: Path) -> None:
        """Open a journal.

        Raises:
            NoRecordError: the file has no whole record.
            UsageError: it does not begin like a journal.
        """
        self.path = path
        self.ended: str | None = None
        """The reason for its end; None if its writer was killed, or if the end has not been read yet."""
        self.flaw: str | None = None
        """What is wrong with the last record that was read, or None."""
        self.damaged = False
        """Whether the flaw is more than a torn last record, which a killed writer leaves."""
        self.heard_s = 0.0
        """The time of the newest input that was read."""
        try:
            self._records = self._read()
            head = next(self._records, None)
        except OSError as error:
            raise UsageError(f"{path}: {error.strerror}") from error
        if not isinstance(head, Head) or head.schema != SCHEMA:
            kind = NoRecordError if head is None and not self.damaged else UsageError
            raise kind(f"{path}: does not begin as a journal of schema {SCHEMA!r}")
        self.head = head

    @property
    def unkept(self) -> str | None:
        """What a full journal lacks, in a sentence; None of others, or before its end has been read."""
        if self.ended != FULL:
            return None
        whose = f"inputs of {robot_name(self.head.robot)} after t={self.heard_s:.1f} s"
        return f"{whose} were not kept: its journal was full (clew run --keep)"

    def turns(self) -> Iterator[Turn]:
        """All turns, oldest first, up to the first record that cannot be read."""
        heard: Input | None = None
        for record in self._records:
            match record:
                case Input() if heard is None and self.ended is None:
                    heard, self.heard_s = record, record.now_s
                case Decision() if heard is not None and self.ended is None:
                    yield Turn(heard, record)
                    heard = None
                case End(why) if self.ended is None:
                    self.ended = why
                case _:
                    self.flaw, self.damaged = "a record stands where it cannot", True
                    return
        if heard is not None:
            yield Turn(heard, None)

    def _read(self) -> Iterator[Written]:
        with open_regular(self.path) as file:
            content = _Content(file)
            unpacker = msgpack.Unpacker(content, max_buffer_size=RECORD_BYTES_MAX)
            whole_bytes = 0
            try:
                for raw in unpacker:
                    record: Written = msgspec.convert(raw, Written)
                    yield _understood(record) if isinstance(record, Input) else record
                    whole_bytes = unpacker.tell()
            except (ValueError, RecursionError, msgpack.UnpackException) as error:
                self.flaw = f"the record at byte {whole_bytes} cannot be read: {error}"[:REASON_LENGTH_MAX]
                self.damaged = True
                return
            if whole_bytes < content.read_bytes:
                self._judge_rest(whole_bytes, self._behind(whole_bytes))
            elif self.ended is not None and not content.is_whole:
                self.flaw = "its end is torn"

    def _behind(self, whole_bytes: int) -> bytes:
        """The content behind the last whole record."""
        with open_regular(self.path) as file:
            content, rest = _Content(file), b""
            while piece := content.read(PIECE_BYTES):
                rest += piece[max(0, len(piece) - (content.read_bytes - whole_bytes)) :]
        return rest

    def _judge_rest(self, whole_bytes: int, rest: bytes) -> None:
        """Classify bytes that are no whole record: torn, unless other records begin within them.

        A changed length byte makes all following records look like one record without an end.
        """
        self.damaged = self.ended is not None or any(rest.find(begin, 1) >= 0 for begin in _BEGINNINGS)
        if self.damaged:
            self.flaw = f"the record at byte {whole_bytes} cannot be read: it has no end"
        else:
            self.flaw = f"its last record is torn: {len(rest)} bytes dropped"


class _Content:
    """The content of a journal's file, packed or not, for a reader that asks for pieces."""

    def __init__(self, file: BufferedReader) -> None:
        self._file = file
        begin = file.peek(len(PACKED))[: len(PACKED)]  # of a torn file it may be shorter
        self._gzip = zlib.decompressobj(GZIP) if PACKED.startswith(begin) else None
        self.read_bytes = 0
        """The bytes of content that were read so far."""

    @property
    def is_whole(self) -> bool:
        """Whether nothing is missing at the end, as far as that shows."""
        return self._gzip is None or self._gzip.eof

    def read(self, size_bytes: int) -> bytes:
        """The next bytes; none at the end of the file.

        Raises:
            ValueError: they cannot be unpacked.
        """
        piece = self._file.read(size_bytes) if self._gzip is None else self._unpacked(self._gzip)
        self.read_bytes += len(piece)
        return piece

    def _unpacked(self, stream: "zlib._Decompress") -> bytes:
        piece = b""
        while not piece and (read := self._file.read(PIECE_BYTES)):
            if stream.eof:
                raise ValueError("something stands behind the end")
            try:
                piece = stream.decompress(read)
            except zlib.error as error:
                raise ValueError(str(error)) from error
        if not piece and stream.unused_data:
            raise ValueError("something stands behind the end")
        return piece


def _understood(heard: Input) -> Input:
    """The input with its event made from the fields."""
    if heard.kind not in _EVENTS:
        raise ValueError(f"{heard.kind!r} is no event")
    return msgspec.structs.replace(heard, event=msgspec.convert(heard.event, _EVENTS[heard.kind]))
