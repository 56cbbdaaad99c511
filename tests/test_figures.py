"""Figures for print: they draw what was judged, the same run gives the same bytes, bad input is said."""

import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

from lab import timeline
from lab.extras import install_line
from lab.figures.course import Course, course_of
from lab.figures.distances import from_hull_m
from lab.figures.run import charts_of
from lab.figures.style import COLUMN_IN, PAGE_IN, Chart, LeftOut, render
from lab.figures.traces import POINTS_MAX, moving_clearance_m, separations_m, thinned
from lab.report import read_verdict
from protocol.arrays import Floats
from protocol.timeline import PoseSampled
from tests.campaigns import clew, closed
from tests.logs import AT_REST, numbered, recorded
from world.recorder import EVENTS_FILE
from world.table import measure
from world.tally import Tally

ROOT = Path(__file__).parents[1]
PLAN = ROOT / "launch" / "faults" / "leader-killed.toml"
FORMATS = ("svg", "pdf", "png")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four runs: the paper's, one whose leader is killed, one with a moving obstacle, one without a way."""
    folder = tmp_path_factory.mktemp("runs")
    calls: dict[str, list[str | Path]] = {
        "paper": ["paper"],
        "killed": ["grove", "--faults", PLAN],
        "pedestrian": ["pedestrian"],
        "closed": [closed(folder / "closed.json")],
    }
    for name, arguments in calls.items():
        clew("rehearse", *arguments, "--seed", "1", "--out", folder / name)
    return folder


def course(folder: Path, name: str) -> Course:
    return course_of(timeline.read(folder / name))


def chart(course: Course, name: str) -> Chart:
    (found,) = (each for each in charts_of(course) if each.name == name)
    assert isinstance(found, Chart)
    return found


def painted(chart: Chart) -> list[Axes]:
    figure = Figure()
    chart.paint(figure)
    return figure.axes


def words(chart: Chart) -> str:
    return " ".join(ET.fromstring(render(chart, ("svg",))["svg"]).itertext())


@pytest.mark.parametrize("name", ["paper", "killed"])
def test_figure_4_draws_the_distances_of_table_1(folder: Path, name: str) -> None:
    read = timeline.read(folder / name)
    tally = Tally()
    for source, entry in read.lines:
        tally.hear(source, entry)
    drawn = course_of(read)
    table_m = np.array(measure(drawn.scenario, tally.switching_positions))
    assert len(table_m) == read_verdict(folder / name).switching_steps + 1
    lines = {line.get_label(): line for line in painted(chart(drawn, "distances"))[0].lines}
    told = [label for label in map(str, lines) if label.startswith("obstacle")]
    assert len(told) == min(6, table_m.shape[1])
    for label in told:
        column_m = table_m[:, int(label.split()[1]) - 1] - drawn.scenario.fleet.robot_radius_m
        drawn_m = np.asarray(lines[label].get_ydata())
        at_table = [stand.place in tally.switching_positions for stand in drawn.stands]
        assert np.array_equal(drawn_m[at_table], column_m)
        assert all(at_table) == (name == "paper")


def test_switching_positions_bear_the_numbers_of_steps_also_where_one_broke_off(folder: Path) -> None:
    drawn = course(folder, "killed")
    begun = [str(planned.plan.step) for planned in drawn.plans]
    assert [stand.name for stand in drawn.stands] == ["1", "1 end", *begun[1:], f"{begun[-1]} end"]
    region = painted(chart(drawn, "region"))[0]
    numbered_m = {text.get_text(): text.xy for text in region.texts if isinstance(text, Annotation)}
    for planned in drawn.plans:
        assert numbered_m[str(planned.plan.step)] == pytest.approx(
            (planned.plan.x_m, planned.plan.y_m), abs=1e-3
        )
    ticks = [label.get_text() for label in painted(chart(drawn, "distances"))[0].get_xticklabels()]
    assert ticks == [stand.name for stand in drawn.stands]


def test_figure_4_tells_apart_the_obstacles_that_were_nearest(folder: Path) -> None:
    drawn = course(folder, "killed")
    least_m = from_hull_m(drawn).min(axis=0)
    labels = [str(line.get_label()) for line in painted(chart(drawn, "distances"))[0].lines]
    told = {int(label.split()[1]) - 1 for label in labels if label.startswith("obstacle")}
    assert told == set(np.argsort(least_m)[:6].tolist())
    assert f"{len(least_m) - 6} others" in labels


@pytest.mark.parametrize("name", ["paper", "killed", "pedestrian"])
def test_every_path_ends_where_its_robot_was_seen_last(folder: Path, name: str) -> None:
    whole = timeline.read(folder / name)
    read = replace(whole, lines=whole.lines[: len(whole.lines) // 2])  # while they drive
    last_m = {
        entry.record.robot: (entry.record.x_m, entry.record.y_m)
        for _, entry in read.lines
        if isinstance(entry.record, PoseSampled)
    }
    lines = painted(chart(course_of(read), "region"))[0].lines
    ends_m = {str(line.get_gid()): np.asarray(line.get_xydata())[-1] for line in lines if line.get_gid()}
    assert {f"path-{robot}": at_m for robot, at_m in last_m.items()} == {
        path: tuple(at_m) for path, at_m in ends_m.items()
    }


@pytest.mark.parametrize("name", ["paper", "killed", "pedestrian"])
def test_the_least_of_each_trace_is_the_verdicts(folder: Path, name: str) -> None:
    verdict, drawn = read_verdict(folder / name), course(folder, name)
    assert drawn.clearance_m.min() == pytest.approx(verdict.clearance_m_min, abs=1e-9)
    assert separations_m(drawn)[1].min() == pytest.approx(verdict.separation_m_min, abs=1e-9)
    if verdict.moving_clearance_m_min is not None:
        least_m = np.nanmin(moving_clearance_m(drawn))
        assert least_m == pytest.approx(verdict.moving_clearance_m_min, abs=1e-9)


@pytest.mark.parametrize("name", ["paper", "killed", "pedestrian"])
def test_the_verdicts_least_is_drawn(folder: Path, name: str) -> None:
    verdict, drawn = read_verdict(folder / name), course(folder, name)
    panels = painted(chart(drawn, "clearance"))
    told = [verdict.clearance_m_min, verdict.moving_clearance_m_min]
    for axes, least_m in zip(panels, told, strict=False):
        assert least_m is not None
        assert min(map(seen_m, axes.lines)) == pytest.approx(least_m, abs=1e-9)
    (axes,) = painted(chart(drawn, "separation"))
    assert min(map(seen_m, axes.lines)) == pytest.approx(verdict.separation_m_min, abs=1e-9)


def seen_m(line: Line2D) -> float:
    """The least of a trace that leaves ink: a point beside another, or one with a marker."""
    if len(np.asarray(line.get_xdata())) < 3:  # a limit, a cross, a succession
        return np.inf
    apart_m = np.asarray(line.get_ydata())
    known = np.pad(np.isfinite(apart_m), 1)
    inked = known[1:-1] & (known[:-2] | known[2:])
    if line.get_linestyle() == "None":
        inked[:] = True
    elif line.get_marker() != "None":
        inked[line.get_markevery()] = True
    return float(np.nanmin(np.where(inked, apart_m, np.inf)))


def test_a_robot_that_drove_for_one_instant_leaves_ink(folder: Path) -> None:
    drawn = course(folder, "pedestrian")
    places_m = drawn.places_m.copy()
    places_m[:50, 1], places_m[50:, 1] = places_m[0, 1], places_m[50, 1]
    stood = replace(drawn, places_m=places_m)
    (at_m,) = (each for each in moving_clearance_m(stood)[:, 1] if np.isfinite(each))
    panel = painted(chart(stood, "clearance"))[1]
    points = [line for line in panel.lines if line.get_marker() == "."]
    assert [at_m] in [np.asarray(line.get_ydata()).tolist() for line in points]


def test_the_trace_of_the_dead_goes_on_as_long_as_its_body(folder: Path) -> None:
    drawn = course(folder, "killed")
    moved = np.diff(drawn.places_m[:, 0], axis=0).any(axis=1)
    stands_s = drawn.times_s[1:][moved].max()
    assert stands_s > drawn.dead[1]
    (axes,) = painted(chart(drawn, "clearance"))
    (trace,) = (line for line in axes.lines if line.get_label() == "robot 1")
    assert np.asarray(trace.get_xdata()).max() == stands_s
    (cross,) = (line for line in axes.lines if line.get_marker() == "x")
    assert drawn.dead[1] <= np.asarray(cross.get_xdata())[0] < stands_s


@pytest.mark.parametrize(
    ("name", "said", "heights"),
    [("pedestrian", "required, 0.040 m", 2), ("paper", "required, above 0 m", 0)],
)
def test_the_separation_required_is_the_verdicts_and_its_axis_has_plain_numbers(
    folder: Path, name: str, said: str, heights: int
) -> None:
    drawn = chart(course(folder, name), "separation")
    assert said in words(drawn)
    (axes,) = painted(drawn)
    required_m = read_verdict(folder / name).separation_m_required
    limits = [line for line in axes.lines if str(line.get_label()).startswith("required")]
    assert [np.asarray(line.get_ydata()).tolist() for line in limits] == [[required_m] * heights]
    assert isinstance(axes.figure, Figure)
    axes.figure.draw_without_rendering()
    assert {text.get_text() for text in axes.get_yticklabels(minor=True)} <= {""}
    assert all(float(text.get_text()) > 0.0 for text in axes.get_yticklabels())


def test_a_trace_that_is_thinned_keeps_its_nearest_point() -> None:
    times_s = np.arange(10_000.0)
    apart_m = np.full(10_000, 1.0)
    apart_m[7_777], apart_m[:100] = 0.01, np.nan
    kept_s, kept_m = thinned(times_s, apart_m)
    assert len(kept_s) <= POINTS_MAX
    assert (kept_s[np.nanargmin(kept_m)], np.nanmin(kept_m)) == (7_777.0, 0.01)


def test_the_dead_and_who_leads_instead_are_marked_where_they_stand(folder: Path) -> None:
    drawn = course(folder, "killed")
    assert list(drawn.dead) == [1]
    region = chart(drawn, "region")
    said = words(region)
    assert "dead body" in said
    assert "leads from here" in said
    crosses = [line for line in painted(region)[0].lines if line.get_marker() == "x"]
    assert [tuple(np.asarray(line.get_xydata())[0]) for line in crosses] == [tuple(drawn.places_m[-1, 0])]
    assert "succession" in words(chart(drawn, "clearance"))


def test_a_run_without_a_way_shows_where_the_leader_stood(folder: Path) -> None:
    drawn = course(folder, "closed")
    assert "no way on" in words(chart(drawn, "region"))
    left_out = [each.name for each in charts_of(drawn) if isinstance(each, LeftOut)]
    assert left_out == ["steps", "distances"]


def test_every_switching_step_has_its_panel_with_the_gap_chosen(folder: Path) -> None:
    drawn = course(folder, "paper")
    panels = [axes for axes in painted(chart(drawn, "steps")) if axes.get_title()]
    assert len(panels) == len(drawn.plans) == 10
    for axes, planned in zip(panels, drawn.plans, strict=True):
        assert planned.plan.gap is not None
        (gap,) = (line for line in axes.lines if line.get_linestyle() == "--")
        width_m = np.hypot(*np.diff(np.asarray(gap.get_xydata()), axis=0)[0])
        assert width_m == pytest.approx(planned.plan.gaps[planned.plan.gap].width_m, abs=1e-6)


def test_lines_stand_where_clearance_has_to_be_kept(folder: Path) -> None:
    drawn = course(folder, "killed")
    law = drawn.scenario.law
    [axes] = painted(chart(drawn, "distances"))
    heights_m = {str(line.get_label()): set(np.asarray(line.get_ydata()).tolist()) for line in axes.lines}
    assert heights_m[r"$\varepsilon$"] == {law.epsilon_m}
    assert heights_m[r"$\varepsilon - \mu_0$"] == {law.epsilon_m - law.mu0_m}


def test_each_panel_has_what_moves_where_it_was_when_the_step_was_planned(tmp_path: Path) -> None:
    clew("rehearse", "door", "--seed", "3", "--out", tmp_path / "door")
    drawn = course(tmp_path, "door")
    panels = [axes for axes in painted(chart(drawn, "steps")) if axes.get_title()]
    places_m, drawn_m = list[Floats](), list[Floats]()
    for axes, planned in zip(panels, drawn.plans, strict=True):
        [moving] = [patch for patch in axes.patches if patch.get_hatch()]
        box = moving.get_path().get_extents(moving.get_patch_transform())
        drawn_m.append(np.mean(box.get_points(), axis=0))
        places_m.extend(drawn.scenario.movers.places_m(planned.t_s))
    assert np.diff(drawn_m, axis=0) == pytest.approx(np.diff(places_m, axis=0), abs=1e-6)
    assert np.ptp(places_m, axis=0).max() > 0.1


@pytest.mark.parametrize("name", ["paper", "killed", "pedestrian"])
def test_panels_of_steps_leave_little_of_the_page_empty(folder: Path, name: str) -> None:
    drawn = chart(course(folder, name), "steps")
    figure = Figure(figsize=drawn.size_in, layout="constrained")
    drawn.paint(figure)
    figure.draw_without_rendering()
    panels = [axes for axes in figure.axes if axes.get_title()]
    first = figure.axes[0].get_subplotspec()
    assert first is not None
    wide = sum(axes.get_position().width for axes in panels[: first.get_gridspec().ncols])
    assert wide > 0.9


@pytest.mark.parametrize("name", ["killed", "closed"])
def test_files_are_valid_as_wide_as_columns_and_hold_text_not_outlines(folder: Path, name: str) -> None:
    for each in charts_of(course(folder, name)):
        if isinstance(each, LeftOut):
            continue
        files = render(each, FORMATS)
        width_in, _ = each.size_in
        assert width_in in (COLUMN_IN, PAGE_IN)
        svg = ET.fromstring(files["svg"])
        assert svg.get("width") == f"{72.0 * width_in:g}pt"
        assert "[m]" in "".join(svg.itertext()) or each.name == "steps"
        assert files["pdf"].startswith(b"%PDF-")
        assert files["pdf"].rstrip().endswith(b"%%EOF")
        assert b"/Subtype /Type3" not in files["pdf"]
        assert files["png"].startswith(b"\x89PNG")
        assert int.from_bytes(files["png"][16:20]) == int(300.0 * width_in)


def test_the_same_run_gives_the_same_bytes_in_another_process_and_whatever_the_user_likes(
    folder: Path, tmp_path: Path
) -> None:
    assert clew("figures", folder / "pedestrian", "--out", tmp_path / "here").exit_code == 0
    (tmp_path / "matplotlibrc").write_text("lines.linewidth: 9\nsavefig.bbox: tight\n", encoding="utf-8")
    subprocess.run(
        [sys.executable, "-m", "lab.cli", "figures", folder / "pedestrian", "--out", tmp_path / "there"],
        env=os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": str(ROOT), "MATPLOTLIBRC": str(tmp_path)},
        check=True,
        capture_output=True,
    )
    names = sorted(path.name for path in (tmp_path / "here").iterdir())
    assert len(names) == 15
    for name in names:
        here, there = (tmp_path / where / name for where in ("here", "there"))
        assert here.read_bytes() == there.read_bytes(), name


def test_figures_stand_in_the_runs_folder_and_every_file_is_named(folder: Path) -> None:
    told = clew("figures", folder / "paper", "--format", "svg, png", "--json")
    said = json.loads(told.stdout)
    assert said["left_out"] == {}
    assert {Path(path).suffix for path in said["written"]} == {".svg", ".png"}
    assert all(Path(path).parent == folder / "paper" / "figures" for path in said["written"])
    assert all(Path(path).exists() for path in said["written"])


def test_a_torn_line_and_a_newer_schema_are_said_and_the_rest_is_drawn(folder: Path, tmp_path: Path) -> None:
    text = (folder / "paper" / EVENTS_FILE).read_bytes()
    newer = tmp_path / EVENTS_FILE
    newer.write_bytes(text[: len(text) // 2].replace(b"clew-timeline/1", b"clew-timeline/2", 1))
    told = clew("figures", newer, "--format", "svg")
    assert told.exit_code == 0
    assert re.search(r"not complete: line \d+ is torn", told.stderr)
    assert "clew-timeline/2" in told.stderr
    assert len(told.stdout.splitlines()) == 5


def test_where_line_1_is_damaged_it_is_said_and_what_entries_alone_tell_is_drawn(
    folder: Path, tmp_path: Path
) -> None:
    _, entries = (folder / "killed" / EVENTS_FILE).read_bytes().split(b"\n", 1)
    headless = tmp_path / EVENTS_FILE
    headless.write_bytes(b'{"kind": "run.started", "sche\n' + entries)
    told = clew("figures", headless, "--format", "svg")
    assert told.exit_code == 0
    assert "not complete: line 1 is damaged" in told.stderr
    assert "not drawn: clearance: the log does not say where obstacles were" in told.stderr
    assert {Path(line).stem for line in told.stdout.splitlines()} == {"region", "steps", "separation"}
    assert "required" not in (tmp_path / "figures" / "separation.svg").read_text(encoding="utf-8")
    checked = clew("log", "check", headless)
    assert checked.exit_code == 2
    assert "line 1, the header, is damaged" in checked.stderr


def test_a_run_in_which_nobody_moved_has_no_distances_and_the_rest_is_drawn(tmp_path: Path) -> None:
    told = clew("figures", recorded(tmp_path / "run", numbered(AT_REST)), "--format", "svg")
    assert told.exit_code == 0
    assert "not drawn: distances: the leader has not begun a switching step\n" in told.stderr
    drawn = {Path(line).stem for line in told.stdout.splitlines()}
    assert drawn == {"region", "clearance", "separation"}


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("empty/", None, "neither a run (events.jsonl) nor a campaign (campaign.json)"),
        ("nothing", None, "there is no such run or campaign"),
        ("notes.txt", "hello", "no header of a run"),
        ("campaign.json", "{}", "no campaign that this program can read"),
        ("campaign.json", '{"episodes": 3}', "no campaign that this program can read"),
    ],
)
def test_what_is_neither_run_nor_campaign_is_refused_in_a_line(
    tmp_path: Path, name: str, content: str | None, why: str
) -> None:
    path = tmp_path / name
    if name.endswith("/"):
        path.mkdir()
    elif content is not None:
        path.write_text(content, encoding="utf-8")
    told = clew("figures", path)
    assert told.exit_code == 2
    assert why in told.stderr
    assert (len(told.stderr.splitlines()), told.stdout) == (1, "")


def test_a_format_that_nobody_knows_and_a_folder_that_is_a_file_are_refused(folder: Path) -> None:
    for option, value in (("--format", "svg,gif"), ("--out", str(folder / "paper" / EVENTS_FILE))):
        told = clew("figures", folder / "paper", option, value)
        assert told.exit_code == 2
        assert len(told.stderr.splitlines()) == 1


def test_without_matplotlib_a_line_names_the_extra(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    told = clew("figures", folder / "paper")
    assert told.exit_code == 2
    assert install_line("plot") in told.stderr


def test_a_figure_leaves_matplotlibs_settings_as_they_were(folder: Path) -> None:
    before = dict(mpl.rcParams)
    render(chart(course(folder, "closed"), "region"), ("svg",))
    assert dict(mpl.rcParams) == before
