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
Rule 5: in a rehearsal, the newest part may stay in memory, up to `keeps_bytes`; it is written when it is
        larger, or when the journal is closed. Nobody outside the process sees an effect before its end, and
        packing each turn by itself takes longer.
"""

import zlib
from collections.abc import Sequence
from io import FileIO
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct

from agents.commands import Command
from agents.events import Event
from agents.robot import Robot
from protocol.fence import Life
from protocol.files.writing import make_folder, open_private
from protocol.frames import Count, RobotId, Seconds
from protocol.keys import robot_name
from protocol.mission import Mission
from protocol.network.session import INPUTS_BYTES_MAX
from protocol.wire.codec import REASON_LENGTH_MAX

SCHEMA = "clew-inputs/2"
SUFFIX = ".clew"
FULL = "full"  # why a journal ends that has no more room
LEVEL = 1  # a quarter of the size for 5 us a record; level 6 takes 7 us and saves 5 % more
GZIP = 31  # zlib's parameter for gzip with the largest window
MEMORY = 5  # zlib's for its own tables: 58 kB less of each robot than its default of 8, and files as large


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
Written = Head | Input | Decision | End


class Given(Struct, frozen=True, gc=False):
    """An event for a core, and the message that carried it."""

    event: Event
    key: str
    """The key without the run's root."""
    number: int
    """The number of the message on its key; 0 if it has none."""


class Journal:
    """Writes one robot's journal; without a file it writes nothing."""

    def __init__(
        self, file: FileIO | None = None, *, size_bytes_max: int = INPUTS_BYTES_MAX, keeps_bytes: int = 0
    ) -> None:
        self._file = file
        self._keeps_bytes = keeps_bytes
        self._kept = bytearray()
        """What is to be written next."""
        self._left_bytes = size_bytes_max
        self._gzip = zlib.compressobj(LEVEL, zlib.DEFLATED, GZIP, MEMORY)
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
        """Write the last input and the decision on it, or keep them (rule 5)."""
        self._write(decision)

    def end(self, why: str) -> None:
        """Write the reason for the end, and close the file."""
        self._write(End(why))

    def _write(self, record: Written) -> None:
        if self._file is None:
            return
        self._kept += self._heard + _PACK(record)
        self._heard = b""
        is_last = isinstance(record, End)
        if is_last or len(self._kept) > self._keeps_bytes:
            self._flush(self._file, is_last=is_last)

    def _flush(self, file: FileIO, *, is_last: bool = False) -> None:
        """Write what is kept."""
        piece = self._gzip.compress(self._kept) + self._gzip.flush(zlib.Z_SYNC_FLUSH)
        self._kept.clear()
        self._left_bytes -= len(piece)
        if self._left_bytes < 0 and not is_last:
            piece, is_last = piece + self._gzip.compress(_PACK(End(FULL))), True
        left = memoryview(piece + self._gzip.flush() if is_last else piece)
        try:
            while left:
                left = left[file.write(left) :]
        except OSError:  # a full disk: the world's recorder ends the run (rule 4)
            is_last = True
        if is_last:
            self.close()

    def close(self) -> None:
        """Write what is kept, and close the file; nothing more is written."""
        file, self._file = self._file, None
        if file is None:
            return
        if self._kept:
            self._flush(file)
        file.close()


def journal_file(folder: Path, robot: int, incarnation: str) -> Path:
    """The journal of a process in the folder of the journals."""
    return folder / f"{robot_name(robot)}-{incarnation}{SUFFIX}"


def open_journal(
    folder: Path | None, head: Head, *, size_bytes_max: int = INPUTS_BYTES_MAX, keeps_bytes: int = 0
) -> Journal:
    """A journal in this folder, which is created if its parent exists; else one without a file."""
    if folder is None:
        return Journal()
    try:
        if not folder.parent.is_dir():
            return Journal()
        make_folder(folder)
        file = open_private(journal_file(folder, head.robot, head.incarnation), "x")
    except OSError:
        return Journal()
    journal = Journal(file, size_bytes_max=size_bytes_max, keeps_bytes=keeps_bytes)
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
    return Decision(tuple([(type(each).__name__, each) for each in commands]))


def failure(error: Exception) -> Decision:
    """A core's failure as a journal record."""
    return Decision((), f"{type(error).__name__}: {error}"[:REASON_LENGTH_MAX])
