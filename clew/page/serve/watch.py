"""Watches one place for a run: its entries as they come, its verdict, and a run that takes its place.

Rule 1: it only ever reads files. It opens no session, so it can put nothing, and nobody waits for it.
Rule 2: a place that leads elsewhere now (`runs/latest`), or a file that is another one, is another run: what
        was told of the one before is void, and the new one is told from its start.
Rule 3: a run is told to its end once, behind every entry: when its verdict is there, or when nobody writes
        any more. What is wrong with it is what a report says then, in the same words.
Rule 4: a run that was told to its end and goes on all the same is void, too, and told from its start.
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
    """A run is there; whatever was told of another one is void."""

    events: Path


@dataclass(frozen=True, slots=True)
class Over:
    """Nothing more will come, and all entries have been told."""

    verdict: dict[str, Any] | None
    flaws: tuple[str, ...]
    """What is left to say of the log and its verdict."""


Marks = tuple[tuple[int, int], ...]
Seen = Began | News | Over


@dataclass(slots=True)
class Watch:
    """Looks at a place, again and again."""

    place: Path
    """A run's folder, or its `events.jsonl`; the way there may lead over a link that is changed later."""
    _which: tuple[Path, int] | None = None
    """The file in truth, and its inode: no two runs share both."""
    _follower: Follower = field(default_factory=Follower)
    _vigil: Vigil = field(default_factory=lambda: Vigil(Path(EVENTS_FILE)))
    _end: Marks | None = None
    """How its files were when it was told to its end."""

    def look(self) -> list[Seen]:
        """What is new, in order: nothing, where there is nothing or no run yet.

        Raises:
            UsageError: the run cannot be read.
        """
        try:
            events = (self.place / EVENTS_FILE if self.place.is_dir() else self.place).resolve(strict=True)
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
        # Before the entries: what was recorded before the verdict is told before it.
        verdict, flaw = verdict_of(events)
        is_over = verdict is not None or self._vigil.is_over(ended=self._follower.ended)
        news = look(events, self._follower)
        if news:
            seen.append(news)
        elif is_over and marks == _marks(events):
            self._end = marks
            flaws = self._follower.close().flaws
            seen.append(Over(verdict, flaws if flaw is None else (*flaws, flaw)))
        return seen


def _marks(events: Path) -> Marks:
    """By what it shows that a run's files have changed: the sizes and times of those that are there."""
    return tuple((stat.st_size, stat.st_mtime_ns) for stat in stats_of(events))
