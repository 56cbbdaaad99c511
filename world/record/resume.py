"""What a timeline tells a world that goes on from it, after a signal has killed the one that wrote it.

Rule 1: whatever a robot was told of its body is on record by then. So the newest place on record is where the
        robot last saw its body, or nearer to where that went; there the body stands now.
Rule 2: an order that was not driven to its end is in hand, but held, as after the dead-man stop: the body
        goes on when its robot confirms the order, and not before.
Rule 3: a world records something at least every `QUIET_S` of a run. So time that goes on from `QUIET_S` after
        the newest entry has never been told before.
"""

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path

import msgspec

from protocol.errors import UsageError
from protocol.files.opening import open_regular
from protocol.files.writing import open_private
from protocol.keys import WORLD, robot_number
from protocol.timeline import (
    Entry,
    OrderAccepted,
    OrderFinished,
    PoseSampled,
    RobotAppeared,
    RobotDied,
    RobotRestarted,
    RobotReturned,
    RobotStarted,
    RunEnded,
    ScanServed,
    WorldResumed,
)
from world.record.lines import Line, read_line
from world.record.recorder import EVENTS_FILE, Header

QUIET_S = 1.0
"""Simulated: the most that a run goes on with no entry of the world's."""


@dataclass(slots=True)
class BodyPast:
    """What is on record of one body."""

    x_m: float = 0.0
    y_m: float = 0.0
    heading_rad: float = 0.0
    sampled: bool = False
    """Whether this place was the last one sampled."""
    order: OrderAccepted | None = None
    """The newest that it took."""
    epoch: int = 0
    """The newest that it was ordered in."""
    finished: int = 0
    """The newest order that it has driven to its end."""
    way_m: list[tuple[float, float]] = field(default_factory=list)
    """Where it was seen since it took the order in hand, or the first of the same switching step."""

    def hear(self, record: object) -> None:
        """Take in what the world recorded of it."""
        match record:
            case PoseSampled():
                self._be(record)
                self.heading_rad, self.sampled = record.heading_rad, True
                self.way_m.append((record.x_m, record.y_m))
            case ScanServed():
                self._be(record)
                self.heading_rad = record.heading_rad
            case OrderAccepted():
                self._be(record)
                self._take(record)
            case OrderFinished():
                self._be(record)
                self.finished = record.number
            case _:
                pass

    def _be(self, place: PoseSampled | ScanServed | OrderAccepted | OrderFinished) -> None:
        moved = (place.x_m, place.y_m) != (self.x_m, self.y_m)
        self.x_m, self.y_m, self.sampled = place.x_m, place.y_m, self.sampled and not moved

    def _take(self, order: OrderAccepted) -> None:
        self.epoch = max(self.epoch, order.epoch)
        if order.target is None:
            self.finished = order.number  # to stand still is done at once
        elif self.order is None or order.step == 0 or order.step != self.order.step:
            self.way_m = [(order.x_m, order.y_m)]
        self.order = order


@dataclass(slots=True)
class Past:
    """A timeline as it was found."""

    header: Header
    lines: Sequence[Line]
    whole_bytes: int
    """How long the file is without a last line that is not whole."""
    torn_bytes: int
    life: int = 1
    """How often the world has gone on by now, this time included."""
    newest_s: float = 0.0
    """Of the world's entries."""
    bodies: dict[int, BodyPast] = field(default_factory=dict)
    """Of those that were placed."""
    come: set[int] = field(default_factory=set)
    dead: set[int] = field(default_factory=set)
    incarnations: dict[int, str] = field(default_factory=dict)
    ended: str | None = None
    """How the run ended, where all but the verdict was written."""

    def __post_init__(self) -> None:
        for source, entry in self.lines:
            robot = robot_number(source)
            if source == WORLD:
                self._hear_world(entry)
            elif robot is not None and isinstance(entry.record, RobotStarted):
                self.incarnations[robot] = entry.record.incarnation

    def _hear_world(self, entry: Entry) -> None:
        self.newest_s = max(self.newest_s, entry.t_s)
        match entry.record:
            case RobotAppeared(robot=robot):
                self.come.add(robot)
            case RobotDied(robot=robot):
                self.dead.add(robot)
            case RobotRestarted(robot=robot) | RobotReturned(robot=robot):
                self.dead.discard(robot)
            case WorldResumed(life=life):
                self.life = life + 1
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
                pass  # the tally and the evidence hear everything

    def said(self) -> Iterator[tuple[str, str, Entry]]:
        """All entries, each with its source and that source's incarnation."""
        lives: dict[str, str] = {}
        for source, entry in self.lines:
            if isinstance(entry.record, RobotStarted) and entry.n == 1:
                lives[source] = entry.record.incarnation
            yield source, lives.get(source, ""), entry


def read_past(folder: Path) -> Past | None:
    """What stands in a run's folder; None where no run has begun there, and a header that is torn is removed.

    Raises:
        UsageError: it cannot be read, or is no timeline of ours.
    """
    path = folder / EVENTS_FILE
    try:
        text = b""
        if path.exists():
            with open_regular(path) as file:
                text = file.read()
        *whole, torn = text.split(b"\n")
        if not whole:
            path.unlink(missing_ok=True)
            return None
        header = msgspec.json.decode(whole[0], type=Header)
        lines = [read_line(line) for line in whole[1:]]
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except (msgspec.MsgspecError, ValueError) as error:
        raise UsageError(f"{path}: no run can go on from it: {error}") from error
    return Past(header, lines, len(text) - len(torn), len(torn))


def continue_events(folder: Path, whole_bytes: int) -> FileIO:
    """The timeline of a run that goes on, cut off where its last whole line ends.

    Raises:
        UsageError: it cannot be written.
    """
    path = folder / EVENTS_FILE
    try:
        file = open_private(path, "r+")
        file.truncate(whole_bytes)
        file.seek(0, os.SEEK_END)
    except OSError as error:
        raise UsageError(f"{path}: cannot be written: {error.strerror}") from error
    return file
