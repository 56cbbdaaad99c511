"""The picture of a scoreboard: it fits its terminal and shows the most important rows."""

import io
import re
from dataclasses import replace

import msgspec
import pytest
from rich.console import Console

from clew.fleet.table_picture import COLUMNS, WORDS, choose, picture, summed_up, table
from clew.fleet.table_rows import Row, Scoreboard
from clew.story.states import State
from protocol.timeline import GoalReached, Record, RobotAppeared, RobotDied
from tests.support.logs.logs import GOOD, HEADER, numbered
from tests.support.long import long
from tests.support.strands import strand
from world.scenario.scenario import load

ROBOTS = 200
MANY = load("paper", robots=ROBOTS)


@pytest.fixture
def many() -> Scoreboard:
    """A strand of 200 robots, one of them dead."""
    header = msgspec.structs.replace(HEADER, scenario=msgspec.json.decode(msgspec.json.encode(MANY)))
    robots = range(1, ROBOTS + 1)
    records: list[tuple[str, Record]] = [("world", RobotAppeared(robot=robot)) for robot in robots]
    records += strand(20_001, *robots)
    records += [("world", RobotDied(robot=117, silent_since_s=0.0))]
    records += [("r1", GoalReached(x_m=0.0, y_m=0.0))] * 8
    board = Scoreboard.of(header)
    for source, entry in numbered(tuple(records)):
        board.hear(source, entry)
    return board


def drawn(board: Scoreboard, *, height: int, width: int = 80, ended: bool = False) -> list[str]:
    console = Console(width=width, height=height, record=True, file=io.StringIO())
    console.print(
        picture(board, GOOD if ended else None, ("the viewer is at http://x",), height=height, width=width)
    )
    return console.export_text().splitlines()


def row(robot: int, place: int | None, state: State) -> Row:
    return Row(
        robot=robot,
        place=place,
        state=state,
        about=(),
        step=None,
        driven_m=0.0,
        share=None,
        clearance_m=None,
        clearance_m_min=None,
        lost=0,
    )


@pytest.mark.parametrize("height", [*range(6, 18, 3), 30, 57, *long(range(18, 57, 3))])
@pytest.mark.parametrize("width", [40, 80, 200])
def test_picture_is_lower_than_its_terminal_and_counts_all_robots(
    many: Scoreboard, height: int, width: int
) -> None:
    lines = drawn(many, height=height, width=width)
    assert len(lines) < height
    rows = [line for line in lines if re.match(r" *r\d+ ", line)]
    (more,) = (line for line in lines if line.startswith("and "))
    assert len(rows) + int(more.split()[1]) == ROBOTS


def test_leader_dead_robots_and_tail_have_priority_when_rows_are_few(many: Scoreboard) -> None:
    lines = drawn(many, height=10)
    assert [line.split()[0] for line in lines if line.split()[0] in ("r1", "r117", "r200")] == [
        "r1",
        "r200",
        "r117",
    ]


def test_messages_and_events_are_shown_if_there_is_room(many: Scoreboard) -> None:
    high, low = drawn(many, height=40), drawn(many, height=12)
    assert high[0] == "the viewer is at http://x"
    assert high[-1].endswith("r1 has reached the goal")
    assert not any("viewer" in line or "goal" in line for line in low)


def test_the_head_names_the_view_by_generation_and_coordinator(many: Scoreboard) -> None:
    assert drawn(many, height=40)[1].endswith("view 2 of r1")


def test_verdict_replaces_the_state_of_the_run(many: Scoreboard) -> None:
    assert "no promise broken so far" in drawn(many, height=40)[2]
    ended = drawn(many, height=40, ended=True)
    assert ended[1] == "OK: every living robot has arrived"


def test_chosen_rows_keep_the_order_of_the_strand() -> None:
    rows = [row(number, number - 1, State.FOLLOWING) for number in range(1, 9)]
    rows[5] = row(6, 5, State.WAITING)
    assert [each.robot for each in choose(rows, 4)] == [1, 6, 8]
    assert choose(rows, 8) == rows


def test_every_state_has_its_own_word() -> None:
    assert set(WORDS) == set(State)
    assert len({word.said for word in WORDS.values()}) == len(State)


def test_leader_has_priority_over_silent_robots_and_those_over_the_tail() -> None:
    rows = [row(number, number - 1, State.FOLLOWING) for number in range(1, 9)]
    rows[3], rows[5] = row(4, 3, State.WAITING), row(6, 5, State.WAITING)
    assert [each.robot for each in choose(rows, 2)] == [1]
    assert [each.robot for each in choose(rows, 4)] == [1, 4, 6]
    assert [each.robot for each in choose(rows, 5)] == [1, 4, 6, 8]


@pytest.mark.parametrize("width", [30, 40, 50, 60, 70, 80])
def test_a_narrow_terminal_has_fewer_columns_but_no_truncated_one(width: int) -> None:
    full = replace(
        row(12, 0, State.ARRIVED),
        step=12,
        driven_m=101.25,
        share=1.0,
        clearance_m=0.1,
        clearance_m_min=0.05,
        lost=1234,
    )
    console = Console(width=width, record=True, file=io.StringIO())
    console.print(table([full], width))
    head, said = console.export_text().splitlines()
    assert set(head.split()) <= set(COLUMNS)
    assert {"robot", "state", "least"} <= set(head.split())
    assert ("…" in said, "0.050 m" in said) == (False, True)
    assert ("lost" in head) == (width >= 80)


def test_current_and_least_clearance_have_separate_columns() -> None:
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(table([replace(row(3, 1, State.FOLLOWING), clearance_m=0.321, clearance_m_min=0.123)], 80))
    head, said = console.export_text().splitlines()
    for name, value in (("clearance", "0.321 m"), ("least", "0.123 m")):
        assert said.index(value) + len(value) == head.index(name) + len(name)


def test_the_summary_line_has_the_least_clearance_of_its_robots() -> None:
    rest = [replace(row(robot, robot, State.ARRIVED), clearance_m_min=0.1 * robot) for robot in (3, 2, 4)]
    assert "least clearance 0.200 m" in summed_up([*rest, row(5, 5, State.ABSENT)]).plain
