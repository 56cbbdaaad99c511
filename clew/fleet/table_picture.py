"""The scoreboard as a picture for a terminal of some size. Pure.

Rule 1: it is never higher than the terminal. If not all rows fit, the leader has priority, then robots that
        are dead, stand or wait because of a fault, then the tail. One line sums up the others.
Rule 2: colour adds no information to the words.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from clew.fleet.table_rows import Row, Scoreboard
from clew.story.states import State
from protocol.fence import NUMBERS
from protocol.keys import robot_name
from protocol.plain import plain
from world.judge.verdict import Verdict

EVENTS_SHOWN = 5
FRAME_LINES = 4  # two for the head, one for the table's head, one free for the cursor
ROWS_FIRST = 8  # with room for fewer rows, messages and events are left out


@dataclass(frozen=True, slots=True)
class _Word:
    """The word for a state and its colour."""

    said: str
    style: str


WORDS = {
    State.NO_WAY: _Word("knows no way", "bold red"),
    State.FAILED: _Word("failed", "bold red"),
    State.DEAD: _Word("dead", "bold red"),
    State.KILLED: _Word("killed", "bold red"),
    State.FROZEN: _Word("frozen", "bold cyan"),
    State.STOPPED: _Word("stopped", "bold yellow"),
    State.STRANDED: _Word("stranded", "bold red"),
    State.ASIDE: _Word("aside", "bold yellow"),
    State.ADRIFT: _Word("gave up", "bold yellow"),
    State.WAITING: _Word("misses", "yellow"),
    State.BLOCKED: _Word("blocked", "bold yellow"),
    State.JOINING: _Word("joining", "magenta"),
    State.BOUND: _Word("lining up", "magenta"),
    State.BACKING_UP: _Word("backing up", "bold green"),
    State.LEADING: _Word("leading", "bold green"),
    State.HOLDING: _Word("holding", "yellow"),
    State.FOLLOWING: _Word("following", ""),
    State.ARRIVED: _Word("arrived", "green"),
    State.ABSENT: _Word("not there yet", "dim"),
}
COLUMNS = ("robot", "place", "state", "step", "driven", "way", "clearance", "least", "lost")
DROPPED = (
    "lost",
    "step",
    "driven",
    "place",
    "way",
    "clearance",
)  # columns to leave out, in this order, on a narrow terminal
GAP = 2  # between two columns
STATE_WIDTH = 13  # of "not there yet": keeps the table's width constant when states change


def picture(
    board: Scoreboard, verdict: Verdict | None, said: Sequence[str], *, height: int, width: int
) -> RenderableType:
    """The picture.

    Args:
        board: the state of the run.
        verdict: on the run; None while it goes on.
        said: the newest messages of the fleet's parts. At the end, the launcher prints all of them.
        height: lines that the terminal has.
        width: characters that a line has.
    """
    above = [] if verdict is not None else [_line(words, style="yellow") for words in said]
    below = [_line(event, style="dim") for event in board.events][-EVENTS_SHOWN:]
    if height < FRAME_LINES + len(above) + len(below) + ROWS_FIRST:
        above = below = []
    room = max(height - FRAME_LINES - len(above) - len(below), 1)
    rows = board.rows
    chosen = choose(rows, room)
    rest = [row for row in rows if row not in chosen]
    return Group(
        *above, *head(board, verdict), table(chosen, width), *([summed_up(rest)] if rest else []), *below
    )


def head(board: Scoreboard, verdict: Verdict | None) -> list[Text]:
    """The scenario and its progress, then the state of the run or its verdict."""
    header = board.header
    what = f"{header.scenario['name']}  {header.scenario['law']['law']}  seed {header.seed}  "
    generation, coordinator = divmod(board.epoch, NUMBERS)
    view = f"view {generation} of {robot_name(coordinator)}" if board.epoch else "no strand yet"
    where = f"t = {board.t_s:.1f} s  step {board.step} planned  {view}"
    return [_line(what + where, style="bold"), _how_it_goes(board, verdict)]


def _how_it_goes(board: Scoreboard, verdict: Verdict | None) -> Text:
    if verdict is not None:
        word, style = ("OK", "bold green") if verdict.ok else ("FAILED", "bold red")
        said = f"{word}: {verdict.reason}"
    elif board.broken:
        said, style = f"promises were broken, {board.broken} so far", "bold red"
    elif board.ended is not None:
        said, style = f"over: {board.ended}", ""
    elif board.is_stopped:
        said, style = "stopped by the operator, no promise broken so far", "bold yellow"
    else:
        said, style = "no promise broken so far", "green"
    return _line(said, style=style)


def choose(rows: Sequence[Row], room: int) -> list[Row]:
    """Rule 1: the rows to show, in the order of the strand, with a line left for the sum of the others."""
    if len(rows) <= room:
        return list(rows)
    tail = max((row.place for row in rows if row.place is not None), default=None)
    telling = sorted(
        rows, key=lambda row: (row.place != 0, row.state >= State.LEADING, row.place != tail, row.state)
    )
    chosen = telling[: max(room - 1, 1)]
    return [row for row in rows if row in chosen]


def summed_up(rest: Sequence[Row]) -> Text:
    """One line for the robots without a row."""
    counts = Counter(row.state for row in rest)
    said = ", ".join(f"{count} {WORDS[state].said}" for state, count in sorted(counts.items()))
    near_m = min((row.clearance_m_min for row in rest if row.clearance_m_min is not None), default=None)
    least = "" if near_m is None else f"; least clearance {near_m:.3f} m"
    return _line(f"and {len(rest)} more: {said}{least}")


def table(rows: Sequence[Row], width: int) -> Table:
    """The rows, with as many complete columns as fit."""
    told = [cells(row) for row in rows]
    names = list(COLUMNS)
    for name in DROPPED:
        widths = [_width(each, [row[each] for row in told]) for each in names]
        if sum(widths) + GAP * (len(widths) - 1) > width:
            names.remove(name)
    drawn = Table(box=None, pad_edge=False, header_style="underline")
    for name in names:
        justify: Literal["left", "right"] = "left" if name == "state" else "right"
        drawn.add_column(name, justify=justify, no_wrap=True, min_width=_width(name, []))
    for row in told:
        drawn.add_row(*(row[name] for name in names))
    return drawn


def _width(name: str, column: Sequence[Text]) -> int:
    """The width of a column."""
    least = STATE_WIDTH if name == "state" else len(name)
    return max(least, *(text.cell_len for text in column), 0)


def cells(row: Row) -> dict[str, Text]:
    """One row, by the names of columns."""
    word = WORDS[row.state]
    about = " ".join(map(robot_name, row.about))
    place = "" if row.place is None else "leader" if row.place == 0 else str(row.place + 1)
    said = (
        Text(robot_name(row.robot)),
        Text(place),
        Text(f"{word.said} {about}".rstrip(), style=word.style),
        Text("" if row.step is None else str(row.step)),
        Text(f"{row.driven_m:.2f} m"),
        Text("" if row.share is None else f"{row.share:.0%}"),
        Text(_metres(row.clearance_m)),
        Text(_metres(row.clearance_m_min)),
        Text(str(row.lost or "")),
    )
    return dict(zip(COLUMNS, said, strict=True))


def _metres(distance_m: float | None) -> str:
    return "" if distance_m is None else f"{distance_m:.3f} m"


def _line(said: str, style: str = "") -> Text:
    """A text that never wraps."""
    return Text(plain(said), style=style, no_wrap=True, overflow="ellipsis")
