"""A robot's inputs and decisions on disk: `inputs/r3-<incarnation>.clew` in the folder of the run.

Rule 1: an input and the decision on it are written before the decision has any effect, both in one unbuffered
        write: a robot that does nothing else pays most for writes. So SIGKILL can only tear the last two
        records, and every effect has its cause on disk. An input on which a core was killed had no effect.
Rule 2: the file is a stream of msgpack that is only appended to: the head, then inputs and decisions in turn,
        then the reason for its end. It is packed by gzip as one stream, which is flushed after each write:
        what repeats costs some bytes, and a killed process leaves what it has written. Older journals are not
        packed.
Rule 3: its size is bounded: a full journal says so and records no more. It keeps the beginning, not the end,
        since a core is replayed from its first input on.
Rule 4: a robot drives on without a journal. If its folder does not exist, as on another computer, none is
        kept.
"""

import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from io import BufferedReader, FileIO
from pathlib import Path
from typing import Annotated, Any, get_args

import msgpack
import msgspec
from msgspec import Meta, Struct

from agents.commands import Command
from agents.events import Event
from agents.robot import Robot
from protocol.errors import UsageError
from protocol.fence import Life
from protocol.files.opening import open_regular
from protocol.files.writing import make_folder, open_private
from protocol.frames import Count, RobotId, Seconds
from protocol.keys import robot_name
from protocol.mission import Mission
from protocol.network.session import INPUTS_BYTES_MAX
from protocol.wire.codec import REASON_LENGTH_MAX

SCHEMA = "clew-inputs/2"
SUFFIX = ".clew"
FULL = "full"  # why a journal ends that has no more room
PACKED = b"\x1f\x8b"  # how a gzip stream begins; a msgpack array does not
LEVEL = 1  # a quarter of the size for 5 us a record; level 6 takes 7 us and saves 5 % more
GZIP = 31  # zlib's parameter for gzip with the largest window
PIECE_BYTES = 1 << 14  # read at a time; gzip packs 1000 bytes into one at most
RECORD_BYTES_MAX = 1 << 24  # 100 times a scan of 7200 rays and the decision on it

_EVENTS: dict[str, type] = {kind.__name__: kind for kind in get_args(Event)}


class Head(Struct, frozen=True, kw_only=True, tag="head", array_like=True):
    """The writer of the journal, and the arguments of its core."""

    schema: str = SCHEMA
    robot: RobotId
    incarnation: Annotated[str, Meta(max_length=64)]
    mission: Mission
    life: Life
    again: bool = False
    """Whether it is the successor of a process that has died."""


class Input(Struct, frozen=True, tag="in", array_like=True):
    """An event for the core, and the message that carried it."""

    now_s: Seconds
    key: str
    """The key without the run's root."""
    number: Count
    """The number of the message on its key; 0 if it has none."""
    kind: str
    event: Any
    """An `Event`, or its fields when it has just been read."""


class Decision(Struct, frozen=True, tag="out", array_like=True):
    """The core's answer: kinds of commands and their fields, or its failure."""

    commands: tuple[tuple[str, Any], ...]
    failed: str | None = None


class End(Struct, frozen=True, tag="end", array_like=True):
    """The end, with its reason. The journal of a killed robot has none."""

    why: str


_PACK = msgspec.msgpack.Encoder().encode  # a fifth of the time that `protocol.wire.codec.packed` takes
_RECORD = Head | Input | Decision | End
_BEGINNINGS = (b"\x96\xa2in\xcb", b"\x93\xa3out", b"\x92\xa3end")
"""The first bytes of records: the number of items and the tag; for an input also the float's marker."""


class Given(Struct, frozen=True, gc=False):
    """An event for a core, and the message that carried it."""

    event: Event
    key: str
    """The key without the run's root."""
    number: int
    """The number of the message on its key; 0 if it has none."""


class Journal:
    """Writes one robot's journal; without a file it writes nothing."""

    def __init__(self, file: FileIO | None = None, *, size_bytes_max: int = INPUTS_BYTES_MAX) -> None:
        self._file = file
        self._left_bytes = size_bytes_max
        self._gzip = zlib.compressobj(LEVEL, zlib.DEFLATED, GZIP)
        self._heard = b""
        """The input that waits for the decision on it."""

    def begin(self, head: Head) -> None:
        """Write the head."""
        self._write(head)

    @property
    def keeps(self) -> bool:
        """Whether it has a file; without one no record has to be made."""
        return self._file is not None

    def hear(self, given: Given, now_s: float) -> None:
        """Keep an input, to be written with the decision on it."""
        if self.keeps:
            kind = type(given.event).__name__
            self._heard += _PACK(Input(now_s, given.key, given.number, kind, given.event))

    def decide(self, decision: Decision) -> None:
        """Write the last input and the decision on it."""
        self._write(decision)

    def end(self, why: str) -> None:
        """Write the reason for the end, and close the file."""
        self._write(End(why))
        self.close()

    def _write(self, record: _RECORD) -> None:
        if self._file is None:
            return
        content, self._heard = self._heard + _PACK(record), b""
        piece = self._gzip.compress(content) + self._gzip.flush(zlib.Z_SYNC_FLUSH)
        self._left_bytes -= len(piece)
        if isinstance(record, End):
            piece += self._gzip.flush()
        elif self._left_bytes < 0:
            piece += self._gzip.compress(_PACK(End(FULL))) + self._gzip.flush()
        left = memoryview(piece)
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError:  # a full disk: the world's recorder ends the run (rule 4)
            self.close()
        if self._left_bytes < 0:
            self.close()

    def close(self) -> None:
        """Close the file; nothing more is written."""
        if self._file is not None:
            self._file.close()
        self._file = None


def open_journal(folder: Path | None, head: Head, *, size_bytes_max: int = INPUTS_BYTES_MAX) -> Journal:
    """A journal in this folder, which is created if its parent exists; else one without a file."""
    if folder is None:
        return Journal()
    try:
        if not folder.parent.is_dir():
            return Journal()
        make_folder(folder)
        file = open_private(folder / f"{robot_name(head.robot)}-{head.incarnation}{SUFFIX}", "x")
    except OSError:
        return Journal()
    journal = Journal(file, size_bytes_max=size_bytes_max)
    journal.begin(head)
    return journal


def decided(core: Robot, given: Given, now_s: float, journal: Journal) -> list[Command]:
    """Let the core handle an event; returns its commands after both are in the journal.

    Raises:
        Exception: any exception of the core, after it is in the journal.
    """
    journal.hear(given, now_s)
    try:
        commands = core.handle(given.event, now_s)
    except Exception as error:
        journal.decide(failure(error))
        raise
    if journal.keeps:
        journal.decide(decision(commands))
    return commands


def decision(commands: Sequence[Command]) -> Decision:
    """Commands as a journal record."""
    return Decision(tuple((type(each).__name__, each) for each in commands))


def failure(error: Exception) -> Decision:
    """A core's failure as a journal record."""
    return Decision((), f"{type(error).__name__}: {error}"[:REASON_LENGTH_MAX])


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


class Recording:
    """A journal as it is read, turn by turn. Its flaw is known only after the last turn."""

    def __init__(self, path: Path) -> None:
        """Open a journal.

        Raises:
            UsageError: the file does not begin like a journal.
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
            raise UsageError(f"{path}: does not begin as a journal of schema {SCHEMA!r}")
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

    def _read(self) -> Iterator[_RECORD]:
        with open_regular(self.path) as file:
            content = _Content(file)
            unpacker = msgpack.Unpacker(content, max_buffer_size=RECORD_BYTES_MAX)
            whole_bytes = 0
            try:
                for raw in unpacker:
                    record: _RECORD = msgspec.convert(raw, _RECORD)
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
        self._gzip = zlib.decompressobj(GZIP) if file.peek(len(PACKED)).startswith(PACKED) else None
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
