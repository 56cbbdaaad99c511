"""Reads the log of a run that is over or goes on, each line once. A shell."""

from pathlib import Path

from clew.fleet.runs import verdict_in
from clew.log.follow import Follower, look
from clew.log.log import Log
from clew.log.uncollected import uncollected
from world.judge.verdict import Verdict
from world.record.lines import Line
from world.record.recorder import EVENTS_FILE, Header


class Reading:
    """What has been read of one run."""

    def __init__(self, run: Path) -> None:
        """Open a run's folder, or its `events.jsonl`.

        Raises:
            UsageError: there is no run.
        """
        self.path = Log(run).path.resolve()
        self.flaws: tuple[str, ...] = ()
        """What cannot be read; after the end, also what is missing."""
        self._header: Header | None = None
        self._follower = Follower(self.path)
        self._lines: list[Line] = []
        self._verdict: Verdict | None = None
        self._is_whole = False

    @property
    def header(self) -> Header:
        """The first line: what was asked for."""
        if self._header is None:
            self._header = Log(self.path).header
        return self._header

    @property
    def lines(self) -> list[Line]:
        """All entries up to now."""
        if self._is_whole:
            return self._lines
        is_over = self.verdict is not None  # asked before the read, so that nothing recorded before is missed
        with uncollected():
            if is_over and not self._lines:  # at once, in two thirds of the time
                log = Log(self.path)
                self._lines = list(log.lines)
                self.flaws, self._is_whole = log.flaws, True
                return self._lines
            while news := look(self._follower):
                self._lines += news.lines
                self.flaws += news.flaws
        if is_over:
            self._is_whole = True
            self.flaws += self._follower.close().flaws
        return self._lines

    @property
    def verdict(self) -> Verdict | None:
        """The verdict; None: the run goes on, or has none that can be read.

        A copy of a log under another name may be of another run than the verdict beside it.
        """
        if self._verdict is None and self.path.name == EVENTS_FILE:
            self._verdict = verdict_in(self.path.parent, Verdict)
        return self._verdict
