"""Watches one place for a run: its entries as they come, its verdict, and a run that takes its place.

Rule 1: it only ever reads files. It opens no session, so it can put nothing, and nobody waits for it.
Rule 2: a place that leads elsewhere now (`runs/latest`), or a file that is another one, is another run: what
        was told of the one before is void, and the new one is told from its start.
Rule 3: the verdict is told once, and behind every entry.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from lab.follow import Follower, News, look
from world.recorder import EVENTS_FILE
from world.verdict import VERDICT_FILE


@dataclass(frozen=True, slots=True)
class Began:
    """A run is there; whatever was told of another one is void."""

    events: Path


@dataclass(frozen=True, slots=True)
class Judged:
    """The verdict is there, and all entries have been told."""

    verdict: dict[str, Any]
    flaws: tuple[str, ...]
    """What is left to say of the log, now that nothing more will come."""


Seen = Began | News | Judged


@dataclass(slots=True)
class Watch:
    """Looks at a place, again and again."""

    place: Path
    """A run's folder, or its `events.jsonl`; the way there may lead over a link that is changed later."""
    _which: tuple[Path, int] | None = None
    """The file in truth, and its inode: no two runs share both."""
    _follower: Follower = field(default_factory=Follower)
    _judged: bool = False

    def look(self) -> list[Seen]:
        """What is new, in order: nothing, where there is nothing or no run yet.

        Raises:
            UsageError: the run cannot be read.
        """
        try:
            events = (self.place / EVENTS_FILE if self.place.is_dir() else self.place).resolve(strict=True)
            which = events, events.stat().st_ino
        except OSError:
            return []
        seen: list[Seen] = []
        if which != self._which:
            self._which, self._follower, self._judged = which, Follower(), False
            seen.append(Began(events))
        # Before the entries: what was recorded before the verdict is told before it.
        verdict = None if self._judged else _verdict(events.with_name(VERDICT_FILE))
        news = look(events, self._follower)
        if news.header or news.heard or news.flaws:
            seen.append(news)
        elif verdict is not None:
            self._judged = True
            seen.append(Judged(verdict, self._follower.close().flaws))
        return seen


def _verdict(path: Path) -> dict[str, Any] | None:
    """What stands there, if it is whole: it may just be being written."""
    try:
        return msgspec.json.decode(path.read_bytes(), type=dict[str, Any])
    except (OSError, msgspec.MsgspecError):
        return None
