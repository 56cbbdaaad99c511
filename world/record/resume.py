"""Restores the state of a world from its timeline, after the process that wrote it was killed.

Rule 1: a pose is recorded before the robot gets it. So the newest recorded pose is the one that the robot
        last saw, or a later one; the body stands there now.
Rule 2: the fence is the last one that was recorded. The world raises it before it obeys or tells anything, so
        no order from before is in hand.
Rule 3: a world records an entry at least every `QUIET_S`. So a clock that continues `QUIET_S` after the
        newest entry shows times that no robot has seen before.
Rule 4: the file is read once, in parts, and no entry is kept: bodies stand while the world is away, and its
        memory does not grow with the run.
"""

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import InitVar, dataclass, field
from io import BufferedReader, FileIO
from pathlib import Path

import msgspec

from protocol.errors import UNREADABLE, UsageError
from protocol.fence import NUMBERS, Epoch, Fence
from protocol.files.opening import open_regular
from protocol.files.writing import open_private
from protocol.keys import WORLD
from protocol.timeline import (
    Entry,
    FenceChanged,
    OrderAccepted,
    OrderFinished,
    PoseSampled,
    PromiseBroken,
    RobotAppeared,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    RunEnded,
    ScanServed,
    WorldResumed,
)
from world.judge.tally import Tally
from world.quota import Quotas
from world.record.lines import Line, read_lines
from world.record.recorder import EVENTS_FILE, Header, held_alone

READ_BYTES = 1 << 18
QUIET_S = 1.0
"""Simulated: the longest time between two entries of the world."""


@dataclass(slots=True)
class BodyPast:
    """The recorded state of one body."""

    x_m: float = 0.0
    y_m: float = 0.0
    heading_rad: float = 0.0
    sampled: bool = False
    """Whether this position is the newest sample."""
    ordered: int = 0
    """The number of the newest order that it accepted."""
    finished: int = 0
    """The number of the newest finished order."""

    def hear(self, record: object) -> None:
        """Process a record about the body."""
        match record:
            case PoseSampled():
                self._be(record)
                self.heading_rad, self.sampled = record.heading_rad, True
            case ScanServed():
                self._be(record)
                self.heading_rad = record.heading_rad
            case OrderAccepted():
                self._be(record)
                self.ordered = record.number
                if record.target is None:
                    self.finished = record.number  # an order to stand is finished at once
            case OrderFinished():
                self._be(record)
                self.finished = record.number
            case _:
                pass

    def _be(self, place: PoseSampled | ScanServed | OrderAccepted | OrderFinished) -> None:
        moved = (place.x_m, place.y_m) != (self.x_m, self.y_m)
        self.x_m, self.y_m, self.sampled = place.x_m, place.y_m, self.sampled and not moved


Hear = Callable[[str, str, Entry], None]
"""Gets an entry of the past: its source, the incarnation of that, and the entry."""


@dataclass(slots=True)
class Past:
    """A timeline found in the run's folder."""

    header: Header
    whole_bytes: int
    """The length of the file without an incomplete last line."""
    torn_bytes: int
    lines: InitVar[Iterable[Line]]
    """Its entries; they are heard once, and not kept."""
    others: InitVar[Sequence[Hear]] = ()
    """What else is to hear them, at the same time."""
    count: int = 0
    """The number of entries."""
    life: int = 1
    """How often the world has been resumed so far, including this time."""
    newest_s: float = 0.0
    """The time of the world's newest entry."""
    bodies: dict[int, BodyPast] = field(default_factory=dict)
    """The bodies that were placed."""
    fence: Fence = field(default_factory=Fence)
    """The newest that was recorded."""
    quotas: Quotas = field(default_factory=Quotas)
    """How often each robot may raise it."""
    come: set[int] = field(default_factory=set)
    dead: set[int] = field(default_factory=set)
    incarnations: dict[int, str] = field(default_factory=dict)
    """Of the newest token that was seen of each robot: its process may have recorded nothing yet."""
    unlawful: set[PromiseBroken] = field(default_factory=set)
    """The violations that were recorded."""
    tally: Tally = field(default_factory=lambda: Tally(is_resumed=True))
    ended: str | None = None
    """The reason for the end, if everything but the verdict was written."""

    def __post_init__(self, lines: Iterable[Line], others: Sequence[Hear]) -> None:
        lives: dict[str, str] = {}
        for source, entry in lines:
            self.count += 1
            self.tally.hear(source, entry)
            if source == WORLD:
                self._hear_world(entry)
            elif entry.n == 1 and isinstance(entry.record, RobotStarted):
                lives[source] = entry.record.incarnation
            for hear in others:
                hear(source, lives.get(source, ""), entry)

    def _hear_world(self, entry: Entry) -> None:
        self.newest_s = max(self.newest_s, entry.t_s)
        match entry.record:
            case RobotAppeared(robot=robot, incarnation=incarnation):
                self.come.add(robot)
                self.incarnations[robot] = incarnation
            case RobotDied(robot=robot):
                self.dead.add(robot)
            case RobotRestarted(robot=robot, incarnation=incarnation):
                self.dead.discard(robot)
                self.incarnations[robot] = incarnation
            case RobotReturned(robot=robot):
                self.dead.discard(robot)
            case FenceChanged() as changed:
                before, self.fence = self.fence, _fence_of(changed)
                self.quotas.hear(before, self.fence, entry.t_s)
            case WorldResumed(life=life):
                self.life = life + 1
            case PromiseBroken() as broken:
                self.unlawful.add(broken)
            case RunEnded(reason=reason):
                self.ended = reason
            case (
                PoseSampled(robot=robot)
                | ScanServed(robot=robot)
                | OrderAccepted(robot=robot)
                | OrderFinished(robot=robot)
            ) as record:
                self.bodies.setdefault(robot, BodyPast()).hear(record)
            case _:
                pass  # the tally and the evidence process all entries


def _fence_of(changed: FenceChanged) -> Fence:
    generation, robot = divmod(changed.epoch, NUMBERS)
    return Fence(
        epoch=Epoch(generation=generation, robot=robot, life=int(changed.life or "0", 16)),
        turn=changed.turn,
        may=changed.may,
        robot=changed.named,
        life=int(changed.named_life or "0", 16),
        members=changed.members,
    )


def read_past(folder: Path, *others: Hear) -> Past | None:
    """Read the timeline in a run's folder; None if no run has begun. An incomplete header is removed.

    Args:
        folder: of the run.
        others: whoever else is to hear the entries: the file is read once.

    Raises:
        UsageError: it cannot be read, or is not a valid timeline.
    """
    path = folder / EVENTS_FILE
    try:
        if not path.exists():
            return None
        with open_regular(path) as file:
            torn_bytes = _torn_bytes(file)
            whole_bytes = file.seek(0, os.SEEK_END) - torn_bytes
            file.seek(0)
            if whole_bytes > 0:
                header = msgspec.json.decode(file.readline(), type=Header)
                return Past(header, whole_bytes, torn_bytes, _lines(file, whole_bytes), others)
        path.unlink()
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except UNREADABLE as error:
        raise UsageError(f"{path}: no run can go on from it: {error}") from error
    return None


def _lines(file: BufferedReader, whole_bytes: int) -> Iterator[Line]:
    """The entries in the rest of a file, up to the end of its last whole line."""
    while (left_bytes := whole_bytes - file.tell()) > 0:
        text = file.read(min(READ_BYTES, left_bytes))
        yield from read_lines(text if text.endswith(b"\n") else text + file.readline())


def _torn_bytes(file: BufferedReader) -> int:
    """How long the text behind the last newline is."""
    end = file.seek(0, os.SEEK_END)
    at = end
    while at > 0:
        at = max(0, at - READ_BYTES)
        file.seek(at)
        if (newline := file.read(min(READ_BYTES, end - at)).rfind(b"\n")) >= 0:
            return end - at - newline - 1
    return end


def continue_events(folder: Path, whole_bytes: int) -> FileIO:
    """Open the timeline of a resumed run, cut off after its last complete line.

    Raises:
        UsageError: it cannot be written, or another world writes it.
    """
    path = folder / EVENTS_FILE
    try:
        file = held_alone(open_private(path, "r+"))
        file.truncate(whole_bytes)
        file.seek(0, os.SEEK_END)
    except BlockingIOError as error:
        raise UsageError(f"{path}: another world writes it") from error
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}") from error
    return file
