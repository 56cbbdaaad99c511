"""The page's drawings compared with the log: map layers, chart marks, signs on the time line."""

import itertools
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np
import pytest
from playwright.sync_api import Browser

from clew.log import timeline
from clew.log.check import scenario_of
from clew.log.timeline import Timeline
from protocol.arrays import Floats, distances_to_segments, scan_bearings_rad
from protocol.frames import Point
from protocol.timeline import (
    AuthorityGranted,
    FaultInjected,
    PoseSampled,
    Record,
    RobotDied,
    ScanServed,
    StepFinished,
    StepPlanned,
    StrandFormed,
    StrandHealed,
)
from tests.support.pages.browser import Sight, sight
from tests.support.pages.canvas import Mark, drawn, layer, record
from tests.support.pages.pages import page_of, told
from tests.support.runs import Runs
from world.record.run_files import read_verdict
from world.scenario.scenario import Scenario

NUMBER_PX = 13.0  # a narrower band has no room for its number
BUSY = str(Path(__file__).with_name("busy.faults.toml"))
KILLED = FaultInjected(fault="kill", rule="kill-4", process="r1")  # in the first step
UNDER_WAY_S = 0.71  # after a step is planned followers are on their way, too
STEP = 4  # of those planned after the strand formed or healed: the followers have followed by then
Kind = TypeVar("Kind", bound=Record)

OFF_M = 0.002  # the page has positions in whole millimetres, as sums of differences


@pytest.fixture(scope="module")
def run(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that loses its leader, its tail and messages."""
    return runs.copy(tmp_path_factory.mktemp("layers") / "run", "grove", faults=BUSY)


@pytest.fixture(scope="module")
def read(run: Path) -> Timeline:
    return timeline.read(run)


@pytest.fixture(params=[StrandFormed, StrandHealed], ids=["five-robots", "three-after-two-died"])
def t_s(request: pytest.FixtureRequest, read: Timeline) -> float:
    """A moment at which the strand is under way."""
    entries = [entry for _, entry in read.lines]
    since_s = next(entry.t_s for entry in entries if isinstance(entry.record, request.param))
    planned_s = [e.t_s for e in entries if isinstance(e.record, StepPlanned) and e.t_s >= since_s]
    return planned_s[STEP - 1] + UNDER_WAY_S


@pytest.fixture(scope="module")
def scenario(read: Timeline) -> Scenario:
    return scenario_of(read)


@pytest.fixture(scope="module")
def batch(run: Path) -> dict[str, Any]:
    [batch] = told(run)
    return batch


@pytest.fixture(scope="module")
def shown(browser: Browser, run: Path) -> Iterator[Sight]:
    """One page for all of these tests; each test seeks its own moment."""
    page = run / "page.html"
    page.write_text(page_of(run), encoding="utf-8")
    with sight(browser) as shown:
        record(shown)
        shown.show(page.as_uri())
        yield shown
        assert shown.troubles == []


def newest(read: Timeline, kind: type[Kind], t_s: float, source: str = "", **fields: object) -> Kind:
    """The last record of this kind up to this time."""
    found = [
        entry.record
        for heard, entry in read.lines
        if isinstance(entry.record, kind)
        and entry.t_s <= t_s
        and source in ("", heard)
        and all(getattr(entry.record, name) == value for name, value in fields.items())
    ]
    assert found, (kind, t_s, source, fields)
    return found[-1]


def order_at(batch: dict[str, Any], t_s: float) -> tuple[int, list[int]]:
    """The epoch and the order of the strand at this time, leader first."""
    strand = [each for each in batch["strands"] if each["t_s"] <= t_s][-1]
    return strand["epoch"], strand["order"]


def samples(read: Timeline, robot: int) -> Floats:
    """Times and places of a body, (n, 3)."""
    return np.array(
        [
            (entry.t_s, entry.record.x_m, entry.record.y_m)
            for _, entry in read.lines
            if isinstance(entry.record, PoseSampled) and entry.record.robot == robot
        ]
    )


def place_at(read: Timeline, robot: int, t_s: float) -> tuple[float, float]:
    rows = samples(read, robot)
    return float(np.interp(t_s, rows[:, 0], rows[:, 1])), float(np.interp(t_s, rows[:, 0], rows[:, 2]))


def along(corners: list[tuple[float, float]], arc_m: float) -> tuple[float, float]:
    """The place on a path at this arc length from its first corner."""
    lengths = np.hypot(*np.diff(np.array(corners), axis=0).T)
    arcs = np.concatenate(([0.0], np.cumsum(lengths)))
    x, y = (np.interp(arc_m, arcs, np.array(corners)[:, axis]) for axis in (0, 1))
    return float(x), float(y)


def pair(point: Point) -> tuple[float, float]:
    return point.x_m, point.y_m


def near(place: tuple[float, float]) -> Any:  # noqa: ANN401 - pytest's own type has no name
    return pytest.approx(place, abs=OFF_M)


def circles(marks: list[Mark]) -> list[tuple[float, ...]]:
    return sorted(arc for mark in marks for arc in mark.arcs)


def test_robots_and_their_halos_are_at_the_poses_of_the_log(
    shown: Sight, read: Timeline, scenario: Scenario, t_s: float
) -> None:
    places = [place_at(read, robot, t_s) for robot in range(1, 6)]
    halo_m = scenario.fleet.robot_radius_m + scenario.law.epsilon_m
    expected = sorted((x_m, y_m, halo_m) for x_m, y_m in places)
    assert circles(layer(shown, "halos", t_s)) == [pytest.approx(each, abs=OFF_M) for each in expected]
    discs = [
        mark.arcs[0] for mark in drawn(shown, t_s) if (mark.on, mark.does) == ("map", "fill") and mark.arcs
    ]
    for x_m, y_m in places:
        assert any(
            disc == pytest.approx((x_m, y_m, scenario.fleet.robot_radius_m), abs=OFF_M) for disc in discs
        )


def test_the_leaders_scan_is_drawn_to_the_ends_of_its_rays(
    shown: Sight, read: Timeline, batch: dict[str, Any], t_s: float
) -> None:
    _, [leader, *_] = order_at(batch, t_s)
    scan = newest(read, ScanServed, t_s, robot=leader)
    ranges_m, bearings_rad = np.array(scan.ranges_m), scan_bearings_rad(len(scan.ranges_m))
    ends = zip(
        scan.x_m + ranges_m * np.cos(bearings_rad), scan.y_m + ranges_m * np.sin(bearings_rad), strict=True
    )
    ground, edge, hits = layer(shown, "scan", t_s)
    assert (ground.does, edge.does, hits.does) == ("fill", "stroke", "fill")
    assert ground.points == edge.points == [near(end) for end in ends]


def test_the_certified_ground_has_the_width_of_hull_and_epsilon_and_the_steps_length(
    shown: Sight, read: Timeline, scenario: Scenario, batch: dict[str, Any], t_s: float
) -> None:
    _, [leader, *_] = order_at(batch, t_s)
    step = newest(read, StepPlanned, t_s, source=f"r{leader}")
    keep_m = scenario.fleet.robot_radius_m + scenario.law.epsilon_m
    [edge] = [mark for mark in layer(shown, "promise", t_s) if mark.does == "stroke"]
    assert not edge.dashed
    expected = sorted([(step.x_m, step.y_m, keep_m), (*pair(step.target), keep_m)])
    assert circles([edge]) == [pytest.approx(each, abs=OFF_M) for each in expected]


def test_the_path_goes_from_its_first_corner_to_its_leaders_target(
    shown: Sight, read: Timeline, batch: dict[str, Any], t_s: float
) -> None:
    epoch, [leader, *_] = order_at(batch, t_s)
    step = newest(read, StepPlanned, t_s, source=f"r{leader}")
    [line] = layer(shown, "path", t_s)
    assert line.points[0] == near(tuple(batch["paths"][str(epoch)][0]))
    assert line.points[-1] == near(pair(step.target))


def test_a_trail_goes_through_all_past_places_of_its_robot_and_no_further(
    shown: Sight, read: Timeline, t_s: float
) -> None:
    lines = layer(shown, "trails", t_s)
    for robot in range(1, 6):
        rows = samples(read, robot)
        been_m = rows[rows[:, 0] <= t_s][:, 1:]
        here = place_at(read, robot, t_s)
        [trail] = [line for line in lines if line.points[-1] == near(here)]
        starts_m, ends_m = np.array(trail.points[:-1]), np.array(trail.points[1:])
        off_m = [distances_to_segments(place, starts_m, ends_m).min() for place in been_m]
        assert max(off_m) < OFF_M
        off_m = [np.hypot(*(np.vstack((been_m, here)) - place).T).min() for place in trail.points]
        assert max(off_m) < OFF_M


def test_authority_ends_at_the_arc_length_that_the_robot_ahead_has_granted(
    shown: Sight, read: Timeline, batch: dict[str, Any], t_s: float
) -> None:
    epoch, order = order_at(batch, t_s)
    bars = [mark for mark in layer(shown, "authority", t_s) if mark.width_px == pytest.approx(6)]
    drives = 0
    for ahead, behind in itertools.pairwise(order):
        granted_m = newest(read, AuthorityGranted, t_s, f"r{ahead}", to=behind).authority_m
        here, end = place_at(read, behind, t_s), along(batch["paths"][str(epoch)], granted_m)
        is_there = math.dist(here, end) < OFF_M
        drives += not is_there
        found = [(bar.points[0], bar.points[-1]) for bar in bars if bar.points[0] == near(here)]
        assert is_there or found == [(near(here), near(end))]
        shown.page.evaluate(f"clew.choose({behind}); clew.draw()")
        assert f"granted {granted_m:.2f} m" in shown.page.locator("#robot-now").inner_text()
    shown.page.evaluate("clew.choose(0)")
    assert drives > 1


def test_a_links_look_changes_with_its_state(shown: Sight, read: Timeline, batch: dict[str, Any]) -> None:
    seen = set()
    for t_s in sorted({change["t_s"] + 0.011 for change in batch["links"]}):
        _, order = order_at(batch, t_s)
        lines = [mark for mark in layer(shown, "links", t_s) if mark.width_px > 0]
        for pair_of in itertools.pairwise(order):
            one, other = sorted(pair_of)
            known = [
                each["state"]
                for each in batch["links"]
                if (each["one"], each["other"]) == (one, other) and each["t_s"] <= t_s
            ]
            state = known[-1] if known else "up"
            ends = [near(place_at(read, robot, t_s)) for robot in pair_of]
            place = next(i for i, mark in enumerate(lines) if mark.points == ends)
            beside = lines[place + 1 : place + 3]
            middle = np.mean([place_at(read, robot, t_s) for robot in pair_of], axis=0)
            ringed = any(mark.arcs and mark.arcs[0][:2] == near(tuple(middle)) for mark in beside[:1])
            strokes = [mark.points for mark in beside if len(mark.points) == 2 and not mark.dashed]
            assert lines[place].dashed == (state != "up")
            assert ringed == (state == "silent")
            if state == "broken":
                assert [np.mean(ends, axis=0) for ends in strokes] == [near(tuple(middle))] * 2
            seen.add(state)
    assert seen == {"up", "silent", "broken"}


def numbers(marks: list[Mark]) -> list[tuple[float, float, float]]:
    """Value, x and y of the numbers on an axis [px]."""
    return [
        (float(mark.text), *mark.points[0])
        for mark in marks
        if mark.does == "text" and mark.text.replace(".", "").isdecimal()
    ]


def axis(told: list[tuple[float, float]]) -> tuple[float, float]:
    """The pixels per unit of an axis with these numbers, and the pixel of 0."""
    values, places = np.array(told).T
    slope, zero = np.polyfit(values, places, 1)
    return float(slope), float(zero)


@pytest.fixture(scope="module")
def stills(shown: Sight) -> list[list[Mark]]:
    """The drawing of each picture that does not change with time."""
    said = shown.page.evaluate(
        "drawn.length = 0; document.getElementById('theme').click(); clew.draw(); drawn"
    )
    marks = [mark for mark in msgspec.convert(said, list[Mark]) if mark.on.startswith("still")]
    return [[mark for mark in marks if mark.on == on] for on in sorted({mark.on for mark in marks})]


def test_the_limit_line_and_the_minimum_are_drawn_at_their_heights(
    stills: list[list[Mark]], run: Path, scenario: Scenario
) -> None:
    [chart] = [marks for marks in stills if any(mark.text == "ε \N{MINUS SIGN} μ0" for mark in marks)]
    left = min(x for _, x, _ in numbers(chart))
    heights = [(value, y - 0.5) for value, x, y in numbers(chart) if x == left]  # on whole pixels
    slope, zero = axis(heights)
    flat = [mark for mark in chart if len(mark.points) == 2 and mark.points[0][1] == mark.points[1][1]]
    law = scenario.law
    for kept_m, is_dashed in ((law.epsilon_m, False), (law.epsilon_m - law.mu0_m, True)):
        lines = [mark.points[0][1] for mark in flat if mark.width_px == 1.25 and mark.dashed == is_dashed]
        assert lines == [pytest.approx(zero + slope * kept_m, abs=0.6)]
    curves = [mark for mark in chart if mark.does == "stroke" and len(mark.points) > 20]
    lowest = max(y for mark in curves for _, y in mark.points if y < zero + 1.0)
    least_m = read_verdict(run).clearance_m_min
    assert least_m is not None
    assert lowest == pytest.approx(zero + slope * least_m, abs=0.6)


def time_line(stills: list[list[Mark]]) -> tuple[list[Mark], float, float]:
    """The drawing of the time line, its pixels per second, and its first pixel."""
    [lanes] = [marks for marks in stills if any(mark.text == "faults" for mark in marks)]
    bottom = max(y for _, _, y in numbers(lanes))
    return lanes, *axis([(value, x) for value, x, y in numbers(lanes) if y == bottom])


def test_each_step_has_a_band_from_its_plan_to_its_end(stills: list[list[Mark]], read: Timeline) -> None:
    lanes, slope, zero = time_line(stills)
    planned = [
        (entry.t_s, entry.record.step) for _, entry in read.lines if isinstance(entry.record, StepPlanned)
    ]
    finished_s = {
        entry.record.step: entry.t_s for _, entry in read.lines if isinstance(entry.record, StepFinished)
    }
    killed_s = next(entry.t_s for _, entry in read.lines if entry.record == KILLED)
    ended_s = [finished_s.get(step, killed_s) for _, step in planned]
    bands = [mark.points for mark in lanes if mark.does == "rect" and mark.points[0][1] == 4.0]
    wide = [(left, right) for (left, _), (right, _) in bands if right - left > 3.0]
    begins = [zero + slope * t_s for t_s, _ in planned]
    assert [left for left, _ in wide] == pytest.approx(begins, abs=1.0)
    assert [right for _, right in wide] == pytest.approx([zero + slope * t_s for t_s in ended_s], abs=1.0)
    [row] = [mark.points[0][1] for mark in lanes if mark.text == "step"]
    roomy = [step for (_, step), (left, right) in zip(planned, wide, strict=True) if right - left > NUMBER_PX]
    assert [value for value, _, y in numbers(lanes) if abs(y - row) < 2.0] == roomy


def test_a_death_has_its_sign_at_its_time(shown: Sight, stills: list[list[Mark]], read: Timeline) -> None:
    lanes, slope, zero = time_line(stills)
    [row] = [mark.points[0][1] for mark in lanes if mark.text == "faults"]
    died_s = {entry.t_s for _, entry in read.lines if isinstance(entry.record, RobotDied)}
    signs = [mark.points[0] for mark in lanes if mark.text == "\N{MULTIPLICATION SIGN}"]
    for t_s in died_s:
        assert any(
            sign == pytest.approx((zero + slope * t_s, row), abs=9.0) for sign in signs
        )  # one beside it
    assert all(y == pytest.approx(row) for _, y in signs)
    said = shown.page.locator("#moments li", has_text="has died")
    assert said.count() == 2
    assert set(said.locator("i").all_inner_texts()) == {"\N{MULTIPLICATION SIGN}"}
