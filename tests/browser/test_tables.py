"""The page's texts compared with log and verdict: tiles, steps, link counts, flaws, moments."""

import itertools
import json
import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser

from clew.log import timeline
from clew.log.check import scenario_of
from clew.log.timeline import Timeline
from protocol.frames import Point
from protocol.timeline import (
    FaultInjected,
    PoseSampled,
    RobotSettled,
    StepFinished,
    StepPlanned,
    TrafficCounted,
)
from tests.support.pages.browser import Sight, sight
from tests.support.pages.canvas import layer, record
from tests.support.pages.pages import page_of
from tests.support.runs import Runs
from world.judge.books import TAKES_AWAY
from world.judge.table import measure
from world.judge.tally import Tally
from world.judge.verdict import Verdict
from world.record.run_files import read_verdict

BUSY = str(Path(__file__).with_name("busy.faults.toml"))
NONE = "\N{EN DASH}"
MOMENTS_SHOWN = 400  # in the page's list


@pytest.fixture(scope="module")
def busy(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that loses its leader, its tail and messages."""
    return runs.copy(tmp_path_factory.mktemp("tables") / "busy", "grove", faults=BUSY)


@pytest.fixture(scope="module")
def paper(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run whose row 7 of Table I was once wrong because it was rounded twice."""
    return runs.copy(tmp_path_factory.mktemp("tables") / "paper", "paper", seed=2)


@pytest.fixture(scope="module")
def pages(browser: Browser, busy: Path, paper: Path) -> Iterator[dict[Path, Sight]]:
    """One page per run for all of these tests."""
    with sight(browser) as one, sight(browser) as other:
        for run, shown in ((busy, one), (paper, other)):
            (run / "page.html").write_text(page_of(run), encoding="utf-8")
            record(shown)
            shown.show((run / "page.html").as_uri())
        yield {busy: one, paper: other}
        assert one.troubles == other.troubles == []


def tile(shown: Sight, name: str) -> str:
    """The text of a tile in the headline, with its remark, which a small window leaves to a tooltip."""
    said = shown.page.locator("#figures > div", has_text=name).first.locator("dd").text_content()
    return " ".join((said or "").split())


def table(shown: Sight, name: str) -> list[list[str]]:
    rows = f"[...document.querySelectorAll('#{name} tbody tr')]"
    cells: list[list[str]] = shown.page.evaluate(
        f"{rows}.map((row) => [...row.children].map((cell) => cell.innerText))"
    )
    return cells


def tally_of(read: Timeline) -> Tally:
    tally = Tally()
    for source, entry in read.lines:
        tally.hear(source, entry)
    return tally


@pytest.mark.parametrize("name", ["busy", "paper"])
def test_tiles_agree_with_the_verdict(
    pages: dict[Path, Sight], name: str, request: pytest.FixtureRequest
) -> None:
    run = request.getfixturevalue(name)
    verdict: Verdict = read_verdict(run)
    expected = {
        "Clearance": f"{verdict.clearance_m_min:.4f} m",
        "Separation": f"{verdict.separation_m_min:.4f} m",
        "Arrived": f"{verdict.robots_arrived} of {verdict.robots} goal reached",
        "Steps": f"{verdict.switching_steps} {verdict.planning_events} planning events of all robots",
        "Time": f"{verdict.sim_s:.1f} s {verdict.path_m:.2f} m driven by all",
        "Messages": f"{verdict.messages.sent} {sum(verdict.messages.injected.values())} removed by faults, "
        f"{verdict.messages.unaccounted} unaccounted",
    }
    assert {
        tile_name: tile(pages[run], tile_name)[: len(said)] for tile_name, said in expected.items()
    } == expected
    assert pages[run].page.locator("#flaws").is_hidden()


def test_deaths_successions_and_heals_are_not_confused(pages: dict[Path, Sight], busy: Path) -> None:
    verdict = read_verdict(busy)
    assert (len(verdict.deaths), len(verdict.successions), len(verdict.heals)) == (2, 1, 1)
    assert tile(pages[busy], "Deaths") == "2 1 succession, 1 heal"


@pytest.mark.parametrize("name", ["busy", "paper"])
def test_each_step_has_its_times_length_and_clearance(
    pages: dict[Path, Sight], name: str, request: pytest.FixtureRequest
) -> None:
    run = request.getfixturevalue(name)
    lines = timeline.read(run).lines
    planned = [
        (entry.t_s, source, entry.record) for source, entry in lines if isinstance(entry.record, StepPlanned)
    ]
    ended = {
        entry.record.step: (entry.t_s, entry.record.clearance_m)
        for _, entry in lines
        if isinstance(entry.record, StepFinished)
    }
    kills = (
        entry.t_s for _, entry in lines if isinstance(entry.record, FaultInjected) and entry.record.process
    )
    killed_s = next(kills, None)  # it breaks off the leader's step
    expected = []
    for t_s, source, step in planned:
        to_s, kept_m = ended.get(step.step, (killed_s, None))
        is_broken = step.step not in ended
        promised = NONE if step.promised_clearance_m is None else f"{step.promised_clearance_m:.3f}"
        kept = NONE if kept_m is None else f"{kept_m:.3f}"
        expected.append(
            [
                str(step.step),
                f"{t_s:.2f}",
                f"{to_s:.2f}{' broken off' * is_broken}",
                source,
                f"{step.length_m:.3f}",
                promised,
                kept,
            ]
        )
    assert [row[:7] for row in table(pages[run], "steps")[1:]] == expected


def test_table_1_has_the_papers_numbers_beside_the_measured_ones_and_marks_the_nearest(
    pages: dict[Path, Sight], paper: Path
) -> None:
    read = timeline.read(paper)
    scenario, stood = scenario_of(read), tally_of(read).switching_positions
    assert scenario.table_m is not None
    cells = "[...row.children].slice(7)"
    texts = "[cell.firstChild.textContent, cell.querySelector('small').textContent, cell.className]"
    rows = pages[paper].page.evaluate(
        f"[...document.querySelectorAll('#steps tbody tr')].map((row) => {cells}.map((cell) => {texts}))"
    )
    for row, measured_m, printed_m in zip(rows, measure(scenario, stood), scenario.table_m, strict=True):
        nearest = measured_m.index(min(measured_m))
        assert row == [
            [f"{here_m:.3f}", f"{paper_m:.3f}", "nearest" * (column == nearest)]
            for column, (here_m, paper_m) in enumerate(zip(measured_m, printed_m, strict=True))
        ]


@pytest.mark.parametrize("name", ["busy", "paper"])
def test_distances_are_measured_from_the_leaders_position(
    pages: dict[Path, Sight], name: str, request: pytest.FixtureRequest
) -> None:
    run = request.getfixturevalue(name)
    read = timeline.read(run)
    scenario = scenario_of(read)
    stood: list[Point] = tally_of(read).switching_positions
    start, *rows = [[f"{distance_m:.3f}" for distance_m in row] for row in measure(scenario, stood)]
    planned = [entry.record.step for _, entry in read.lines if isinstance(entry.record, StepPlanned)]
    finished = {entry.record.step for _, entry in read.lines if isinstance(entry.record, StepFinished)}
    after = iter(rows)
    expected = [start, *(next(after) if step in finished else [NONE] * len(start) for step in planned)]
    shown = pages[run].page.evaluate(
        "[...document.querySelectorAll('#steps tbody tr')].map((row) => "
        "[...row.children].slice(7).map((cell) => cell.firstChild.textContent))"
    )
    assert shown == expected


def books_of(read: Timeline) -> dict[str, list[str]]:
    """Each link's row, from the counts of its two robots, if they are known."""
    sent, received, taken = dict[str, int](), dict[str, int](), Counter[str]()
    told, heard = set(), set()
    for source, entry in read.lines:
        match entry.record:
            case RobotSettled(sent=counts):
                told.add(source)
                sent |= counts
            case TrafficCounted() as counted:
                heard.add(source)
                received |= counted.received
                for counts in counted.injected.values():
                    taken.update(counts)
            case _:
                pass
    rows = {}
    for key in sorted({key for key in (*sent, *received) if key.startswith("link/")}):
        _, one, other = key.split("/")
        if one in told and other in heard:
            lost = 100 * (sent[key] - received[key]) / sent[key]
            cells = [str(sent[key]), str(received[key]), str(taken[key]), f"{lost:.1f} %"]
        else:
            halves = [str(sent.get(key, NONE)), str(received.get(key, NONE))]
            cells = [*halves, NONE, "not known: its process died"]
        rows[f"{one[1:]} → {other[1:]}"] = cells
    return rows


def test_link_counts_show_losses_and_mark_unknown_ones(pages: dict[Path, Sight], busy: Path) -> None:
    expected = books_of(timeline.read(busy))
    assert {row[0]: row[1:] for row in table(pages[busy], "messages")} == expected
    left_out = [
        book.split("/")[1:] for book in read_verdict(busy).messages.left_out if book.startswith("link/")
    ]
    unknown = {name for name, cells in expected.items() if "not known" in cells[-1]}
    assert unknown == {f"{one[1:]} → {other.split()[0][1:]}" for one, other in left_out}
    assert len(unknown) < len(expected)


def test_late_and_duplicated_messages_are_not_lost(pages: dict[Path, Sight], busy: Path) -> None:
    faults = [
        entry.record for _, entry in timeline.read(busy).lines if isinstance(entry.record, FaultInjected)
    ]
    of_links = [fault for fault in faults if fault.key is not None and fault.key.startswith("link/")]
    assert {fault.fault for fault in of_links} == {"delay", *TAKES_AWAY}
    keys = [fault.key.split("/")[1:] for fault in of_links if fault.key and fault.fault in TAKES_AWAY]
    expected = Counter(f"{one[1:]} > {other[1:]}" for one, other in keys)
    curves = "[...clew.runs[0].losses.taken].map(([link, curve]) => [link, curve.value.last])"
    assert dict(pages[busy].page.evaluate(curves)) == expected


def test_the_marked_gap_is_the_chosen_one(pages: dict[Path, Sight], paper: Path) -> None:
    steps = [
        (entry.t_s, entry.record)
        for _, entry in timeline.read(paper).lines
        if isinstance(entry.record, StepPlanned)
    ]
    t_s, step = next((t_s, step) for t_s, step in steps if step.gap is not None and len(step.gaps) > 1)
    assert step.gap is not None
    gap = step.gaps[step.gap]
    ends = [step.obstacles[gap.right].tangent_2, step.obstacles[gap.left].tangent_1]
    marks = layer(pages[paper], "sight", t_s + 0.01)
    [wide] = [mark for mark in marks if mark.does == "stroke" and mark.width_px == pytest.approx(2.5)]
    assert wide.points == [pytest.approx((end.x_m, end.y_m), abs=0.002) for end in ends]
    assert [mark.text for mark in marks if mark.does == "text"] == [f"gap {gap.width_m:.2f} m"]


def test_arc_length_is_the_steps_end_minus_the_remaining_distance(
    pages: dict[Path, Sight], busy: Path
) -> None:
    shown = pages[busy]
    lines = timeline.read(busy).lines
    steps = [
        (entry.t_s + 0.5, source, entry.record)
        for source, entry in lines
        if isinstance(entry.record, StepPlanned)
    ]
    for t_s, source, step in steps:
        robot = int(source[1:])
        poses = [
            (entry.t_s, entry.record.x_m, entry.record.y_m)
            for _, entry in lines
            if isinstance(entry.record, PoseSampled) and entry.record.robot == robot
        ]
        times_s, *axes_m = np.array(poses).T
        here_m = [float(np.interp(t_s, times_s, axis_m)) for axis_m in axes_m]
        shown.page.evaluate(f"clew.seek({t_s}); clew.choose({robot}); clew.draw()")
        said = shown.page.locator("#robot-now").inner_text()
        along_m = float(said.split(" m along the path")[0].rsplit(" ", 1)[1])
        left_m = math.dist(here_m, (step.target.x_m, step.target.y_m))
        assert along_m == pytest.approx(step.reach_m - left_m, abs=0.01)
    shown.page.evaluate("clew.choose(0)")


def test_playing_stops_at_the_end_and_restarts_from_the_beginning(
    pages: dict[Path, Sight], paper: Path
) -> None:
    shown = pages[paper]
    button = "document.getElementById('play')"
    shown.page.evaluate("clew.seek(clew.runs[0].end - 0.05)")
    shown.page.evaluate(f"{button}.click()")
    shown.wait("clew.time === clew.runs[0].end")
    shown.wait(f"{button}.getAttribute('aria-pressed') === 'false'")
    assert "Play" in shown.page.locator("#play").inner_text()
    shown.page.evaluate(f"{button}.click()")
    shown.wait("clew.time > 0 && clew.time < clew.runs[0].end / 2")
    shown.page.evaluate(f"{button}.click()")


def test_flaws_and_the_number_of_omitted_moments_are_shown(pages: dict[Path, Sight], busy: Path) -> None:
    """This test comes last because it changes the page."""
    shown = pages[busy]
    known = shown.page.locator("#moments li").count()
    assert shown.page.locator("#moments-about").inner_text() == ""
    count = 500
    silent: dict[str, Any] = {
        "i": [1] * count,
        "t": [5000, *[1] * (count - 1)],
        "source": ["r3"] * count,
        "neighbour": [4] * count,
        "silent_s": [0.5] * count,
        "says": ["r3 does not hear r4"] * count,
    }
    flaws = [f"flaw {i} <b>" for i in range(25)]
    batch = json.dumps({"entries": {"link.silent": silent}, "flaws": flaws})
    shown.page.evaluate(f"clew.take(0, {batch})")
    shown.wait("!document.getElementById('flaws').hidden")
    said = shown.page.locator("#flaws li").all_inner_texts()
    assert said == [*flaws[:20], "and 5 more"]
    assert shown.page.locator("#flaws").is_visible()
    about = shown.page.locator("#moments-about").inner_text()
    assert about.startswith(f"{MOMENTS_SHOWN} of {known + count}")
    listed = shown.page.locator("#moments time").all_inner_texts()
    assert len(listed) == MOMENTS_SHOWN
    assert all(float(one) <= float(other) for one, other in itertools.pairwise(listed))
