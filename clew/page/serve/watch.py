"""Watches one place for a run: its entries as they come, its verdict, and the next run in its place.

Rule 1: it only reads files. It opens no session, so it can publish nothing, and no process waits for it.
Rule 2: if the place points elsewhere (`runs/latest`) or the file is a different one, there is another run.
        Everything sent about the earlier run is void; the new run is sent from its start.
Rule 3: the end of a run is sent once, after every entry: when its verdict is there or when nobody writes any
        more. Its flaws are then the same as in a report, in the same words.
Rule 4: if a run continues after its end was sent, everything sent is void, and it is sent from its start.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from clew.log.follow import Follower, News, look
from clew.log.vigil import Vigil, stats_of
from clew.page.telling import verdict_of
from world.record.recorder import EVENTS_FILE


@dataclass(frozen=True, slots=True)
class Began:
    """A run has begun; everything sent about an earlier one is void."""

    events: Path


@dataclass(frozen=True, slots=True)
class Over:
    """Nothing more will follow, and all entries have been sent."""

    verdict: dict[str, Any] | None
    flaws: tuple[str, ...]
    """The remaining flaws of the log, and its verdict."""


Marks = tuple[tuple[int, int], ...]
Seen = Began | News | Over


@dataclass(slots=True)
class Watch:
    """Reads a place repeatedly."""

    place: Path
    """A run's folder or its `events.jsonl`; the path may contain a link that changes later."""
    _which: tuple[Path, int] | None = None
    """The resolved path and the inode: no two runs share both."""
    _follower: Follower = field(default_factory=lambda: Follower(Path(EVENTS_FILE)))
    _vigil: Vigil = field(default_factory=lambda: Vigil(Path(EVENTS_FILE)))
    _end: Marks | None = None
    """The state of its files when its end was sent."""

    def look(self) -> list[Seen]:
        """The news in order; empty if there are none or there is no run yet.

        Raises:
            UsageError: the run cannot be read.
        """
        try:
            place = self.place.resolve(strict=True)  # first: the link may come, or change, at any moment
            events = (place / EVENTS_FILE).resolve(strict=True) if place.is_dir() else place
            which, marks = (events, events.stat().st_ino), _marks(events)
        except OSError:
            return []
        seen: list[Seen] = []
        if which != self._which or self._end not in {None, marks}:
            self._which, self._end = which, None
            self._follower, self._vigil = Follower(events), Vigil(events)
            seen.append(Began(events))
        if self._end is not None:
            return seen
        # Read before the entries: entries recorded before the verdict are sent before it.
        verdict, flaw = verdict_of(events)
        is_over = verdict is not None or self._vigil.is_over(ended=self._follower.ended)
        news = look(self._follower)
        if news:
            seen.append(news)
        elif is_over and marks == _marks(events):
            self._end = marks
            flaws = self._follower.close().flaws
            seen.append(Over(verdict, flaws if flaw is None else (*flaws, flaw)))
        return seen


def _marks(events: Path) -> Marks:
    """The sizes and times of a run's files, which show whether they have changed."""
    return tuple((stat.st_size, stat.st_mtime_ns) for stat in stats_of(events))
