"""`python -m clew.fleet.table RUN`: the live table of a run, on stderr. `launch/fleet.sh` starts and ends it.

Rule 1: it reads only the timeline. The fleet neither waits for it nor knows about it.
Rule 2: it ends when the verdict is there, when it is asked to, or when its launcher has gone. Before that, it
        draws everything recorded until then.
"""

import argparse
import asyncio
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.live import Live

from clew.fleet.runs import verdict_in
from clew.fleet.table_picture import picture
from clew.fleet.table_rows import Scoreboard
from clew.fleet.table_said import Said
from clew.log.follow import Follower, look
from protocol.process.ending import asked_to_end
from world.judge.verdict import Verdict
from world.record.recorder import EVENTS_FILE

DRAW_S = 0.2  # wall clock: five pictures per second look live and cost a few percent of one core
STDIN = 0


class Watch:
    """The state of the run in a folder, as read so far."""

    def __init__(self, run: Path, said: Path) -> None:
        self._run = run
        self._said = Said(said)
        self._follower = Follower(run / EVENTS_FILE)
        self._board: Scoreboard | None = None
        self._verdict: Verdict | None = None

    @property
    def judged(self) -> bool:
        """Whether the verdict is there: nothing follows it."""
        return self._verdict is not None

    def look(self) -> bool:
        """Read new entries; returns whether there were any."""
        news = look(self._follower)
        said = self._said.look()
        if news.header is not None:
            self._board = Scoreboard.of(news.header)
        if self._board is not None:
            for source, entry in news.lines:
                self._board.hear(source, entry)
        was_judged = self.judged
        self._verdict = self._verdict or verdict_in(self._run, Verdict)
        return bool(news.header or news.lines or said or self.judged != was_judged)

    def draw(self, live: Live) -> None:
        """Draw the current state."""
        if self._board is not None:
            width, height = live.console.size
            drawn = picture(self._board, self._verdict, self._said.newest, height=height, width=width)
            live.update(drawn, refresh=True)


async def watch(run: Path, said: Path) -> None:
    """Show the table until we are asked to end."""
    console, seen = Console(stderr=True), Watch(run, said)
    with asked_to_end(STDIN) as ending, Live(console=console, auto_refresh=False) as live:
        while not (ending.done() or seen.judged):
            if seen.look():
                seen.draw(live)
            await asyncio.wait({ending}, timeout=DRAW_S)
        while seen.look():
            pass
        seen.draw(live)  # the picture that stays


def main(arguments: Sequence[str]) -> None:
    """Watch a run."""
    parser = argparse.ArgumentParser(prog="python -m clew.fleet.table", description=__doc__)
    parser.add_argument("run", type=Path, metavar="RUN", help="the run's folder; it may not exist yet")
    parser.add_argument(
        "--said",
        type=Path,
        required=True,
        metavar="FILE",
        help="the file with the output of the fleet's parts",
    )
    asked = parser.parse_args(arguments)
    asyncio.run(watch(asked.run, asked.said))


if __name__ == "__main__":
    main(sys.argv[1:])
