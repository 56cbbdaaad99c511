"""The batches of a finished run, from its folder: everything that is readable, and the flaws.

Rule 1: a folder without a timeline, or without a valid header, still makes a page, which says so.
Rule 2: entries are packed every `AT_ONCE`, so that a log of a million entries is never in memory as a whole.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec

from clew.log.log import Log
from clew.page.batches import Batches
from protocol.errors import UNREADABLE, UsageError
from protocol.files.opening import MADE_BYTES_MAX, read_bytes
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE

AT_ONCE = 20_000  # entries: about 10 MB


class Telling:
    """A run for a single pass, batch by batch."""

    def __init__(self, run: Path) -> None:
        """A run's folder, or its `events.jsonl`."""
        self._folder = folder_of(run)
        self._verdict, flaw = verdict_of(run)
        self.flaws: tuple[str, ...] = () if flaw is None else (flaw,)
        """The flaws of the run, in sentences; complete after the last batch."""
        self._log: Log | None = None
        try:
            self._log = Log(run)
        except UsageError as error:
            self.flaws = (str(error), *self.flaws)

    @property
    def is_there(self) -> bool:
        """Whether there is a timeline."""
        return self._log is not None

    def batches(self) -> Iterator[bytes]:
        """All batches of the run, for `clew.take`."""
        batches = Batches(None if self._log is None else self._log.header, self._folder)
        for count, (source, entry) in enumerate(() if self._log is None else self._log.lines, start=1):
            batches.hear(source, entry)
            if count % AT_ONCE == 0:
                yield from _some(batches.batch())
        flaws = () if self._log is None else self._log.flaws
        batches.add(verdict=self._verdict, flaws=(*flaws, *self.flaws))
        self.flaws = batches.flaws
        yield from _some(batches.batch(ended=True))


def folder_of(run: Path) -> str:
    """The page's name for the place of a run: its folder's name, or the name of a single log file."""
    place = run.resolve()
    return place.parent.name if place.name == EVENTS_FILE else place.name


def _some(batch: bytes | None) -> Iterator[bytes]:
    if batch is not None:
        yield batch


def verdict_of(run: Path) -> tuple[dict[str, Any] | None, str | None]:
    """The verdict beside the timeline, and its flaw. `run`: as in `Telling`."""
    if run.is_file() and run.name != EVENTS_FILE:
        return None, None  # a copy under another name may be of another run
    path = (run if run.is_dir() else run.parent) / VERDICT_FILE
    try:
        return msgspec.json.decode(read_bytes(path, MADE_BYTES_MAX), type=dict[str, Any]), None
    except FileNotFoundError:
        return None, f"there is no {VERDICT_FILE}"
    except OSError as error:  # the text of this error has its number and the whole path
        return None, f"{VERDICT_FILE} cannot be read: {error.strerror}"
    except UNREADABLE as error:
        return None, f"{VERDICT_FILE} cannot be read: {error}"
