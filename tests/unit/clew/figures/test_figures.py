"""Figures for print: they agree with the verdict, and the same run gives the same bytes."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

from clew.figures.distances import from_hull_m
from clew.figures.ground import patch_of
from clew.figures.run import charts_of
from clew.figures.style import COLUMN_IN, LOOKS, MARK, PAGE_IN, Chart, LeftOut, render
from clew.figures.traces import POINTS_MAX, moving_clearance_m, separations_m, thinned
from clew.log import timeline
from clew.story.course import course_of
from protocol.files.writing import check_ours
from protocol.root import ROOT
from protocol.timeline import PoseSampled
from tests.support.campaigns import clew, closed
from tests.support.deadline import DEADLINE_S
from tests.support.figures import chart, course, painted
from tests.support.long import long
from tests.support.runs import Runs
from world.judge.table import measure
from world.judge.tally import Tally
from world.record.run_files import read_verdict

FORMATS = ("svg", "pdf", "png")


@pytest.fixture(scope="module")
def folder(runs: Runs, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four runs: the paper's, one with a killed leader, one with a moving obstacle, one without a way."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "paper").symlink_to(runs.of("paper"))
    (folder / "killed").symlink_to(runs.of("grove", faults="leader-killed"))
    (folder / "pedestrian").symlink_to(runs.of("pedestrian"))
    clew("rehearse", closed(folder / "closed.json"), "--seed", "1", "--out", folder / "closed")
    return folder


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


def test_figure_4_has_the_papers_own_values_as_hollow_markers(folder: Path) -> None:
    drawn = course(folder / "paper")
    table_m = np.array(drawn.scenario.table_m)
    axes = painted(chart(drawn, "distances"))[0]
    hollow = [
        line for line in axes.lines if line.get_markerfacecolor() == "none" and np.size(line.get_xdata())
    ]
    assert [line.get_color() for line in hollow] == [look.colour for look in LOOKS[: table_m.shape[1]]]
    for line, column_m in zip(hollow, table_m.T, strict=True):
        rows = np.asarray(line.get_xdata()) - 1
        assert rows.tolist() == list(range(min(len(drawn.stands), len(table_m))))
        assert np.asarray(line.get_ydata()) == pytest.approx(column_m[rows])
    assert "paper's Table I" in words(chart(drawn, "distances"))
    assert "paper's Table I" not in words(chart(course(folder / "killed"), "distances"))


def test_every_obstacle_has_its_number_on_it_and_every_gap_that_of_its_step(folder: Path) -> None:
    drawn = course(folder / "killed")
    axes = painted(chart(drawn, "region"))[0]
    numbers = [text for text in axes.texts if str(text.get_gid()).startswith("obstacle-")]
    shapes = drawn.scenario.obstacles
    assert [text.get_text() for text in numbers] == [str(number) for number in range(1, len(shapes) + 1)]
    for text, shape in zip(numbers, shapes, strict=True):
        patch = patch_of(shape)
        x_m, y_m = patch.get_patch_transform().inverted().transform(text.get_position())
        assert patch.get_path().contains_point((float(x_m), float(y_m)))
    paper = course(folder / "paper")
    gaps = {text.get_text() for text in painted(chart(paper, "region"))[0].texts}
    assert {f"g{step.number}" for step in paper.steps} <= gaps


def test_robots_on_one_path_are_told_apart_by_the_widths_of_their_lines(folder: Path) -> None:
    lines = painted(chart(course(folder / "killed"), "region"))[0].lines
    paths = [line for line in lines if str(line.get_gid()).startswith("path-")]
    widths_pt = [line.get_linewidth() for line in paths]  # the widest is drawn first, below the others
    assert widths_pt == sorted(set(widths_pt), reverse=True)
    assert len(widths_pt) == 5


def test_switching_positions_have_the_steps_numbers_even_after_an_interrupted_step(folder: Path) -> None:
    drawn = course(folder / "killed")
    begun = [str(planned.number) for planned in drawn.steps]
    names = [stand.name for stand in drawn.stands]
    assert [name for name in names if not name.endswith(" end")] == begun
    assert (names[1], names[-1]) == ("1 end", f"{begun[-1]} end")
    region = painted(chart(drawn, "region"))[0]
    numbered_m = {text.get_text(): text.xy for text in region.texts if isinstance(text, Annotation)}
    for planned in drawn.steps:
        assert numbered_m[str(planned.number)] == pytest.approx(
            (planned.plan.x_m, planned.plan.y_m), abs=1e-3
        )
    ticks = [label.get_text() for label in painted(chart(drawn, "distances"))[0].get_xticklabels()]
    assert ticks == [stand.name for stand in drawn.stands]


def test_figure_4_distinguishes_the_nearest_obstacles(folder: Path) -> None:
    drawn = course(folder / "killed")
    least_m = from_hull_m(drawn).min(axis=0)
    labels = [str(line.get_label()) for line in painted(chart(drawn, "distances"))[0].lines]
    told = {int(label.split()[1]) - 1 for label in labels if label.startswith("obstacle")}
    assert told == set(np.argsort(least_m)[:6].tolist())
    assert f"{len(least_m) - 6} others" in labels


@pytest.mark.parametrize("name", ["paper", "killed", "pedestrian"])
def test_every_path_ends_at_its_robots_last_pose(folder: Path, name: str) -> None:
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
def test_the_minimum_of_each_trace_is_the_verdicts(folder: Path, name: str) -> None:
    verdict, drawn = read_verdict(folder / name), course(folder / name)
    assert drawn.clearance_m.min() == pytest.approx(verdict.clearance_m_min, abs=1e-9)
    assert separations_m(drawn)[1].min() == pytest.approx(verdict.separation_m_min, abs=1e-9)
    if verdict.moving_clearance_m_min is not None:
        least_m = np.nanmin(moving_clearance_m(drawn))
        assert least_m == pytest.approx(verdict.moving_clearance_m_min, abs=1e-9)


@pytest.mark.parametrize("name", ["paper", "killed", "pedestrian"])
def test_the_verdicts_minimum_is_drawn(folder: Path, name: str) -> None:
    verdict, drawn = read_verdict(folder / name), course(folder / name)
    panels = painted(chart(drawn, "clearance"))
    told = [verdict.clearance_m_min, verdict.moving_clearance_m_min]
    for axes, least_m in zip(panels, told, strict=False):
        assert least_m is not None
        assert min(map(seen_m, axes.lines)) == pytest.approx(least_m, abs=1e-9)
    (axes,) = painted(chart(drawn, "separation"))
    assert min(map(seen_m, axes.lines)) == pytest.approx(verdict.separation_m_min, abs=1e-9)


def seen_m(line: Line2D) -> float:
    """The least value of a trace that is visible: a point beside another, or one with a marker."""
    if len(np.asarray(line.get_xdata())) < 3:  # a limit, a cross, a succession
        return np.inf
    apart_m = np.asarray(line.get_ydata())
    known = np.pad(np.isfinite(apart_m), 1)
    inked = known[1:-1] & (known[:-2] | known[2:])
    if line.get_linestyle() == "None":
        inked[:] = True
    elif line.get_marker() != "None":
        inked[np.asarray(line.get_markevery())] = True
    return float(np.nanmin(np.where(inked, apart_m, np.inf)))


def test_a_robot_that_drove_for_one_instant_is_visible(folder: Path) -> None:
    drawn = course(folder / "pedestrian")
    places_m = drawn.places_m.copy()
    places_m[:50, 1] = places_m[0, 1]
    places_m[50:, 1] = places_m[50, 1]
    stood = replace(drawn, places_m=places_m)
    (at_m,) = (each for each in moving_clearance_m(stood)[:, 1] if np.isfinite(each))
    panel = painted(chart(stood, "clearance"))[1]
    points = [line for line in panel.lines if line.get_marker() == "."]
    assert [at_m] in [np.asarray(line.get_ydata()).tolist() for line in points]


def test_the_trace_of_a_dead_robot_lasts_as_long_as_its_body_moves(folder: Path) -> None:
    drawn = course(folder / "killed")
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
def test_the_required_separation_is_the_verdicts_and_its_axis_has_plain_numbers(
    folder: Path, name: str, said: str, heights: int
) -> None:
    drawn = chart(course(folder / name), "separation")
    assert said in words(drawn)
    (axes,) = painted(drawn)
    required_m = read_verdict(folder / name).separation_m_required
    limits = [line for line in axes.lines if str(line.get_label()).startswith("required")]
    assert [np.asarray(line.get_ydata()).tolist() for line in limits] == [[required_m] * heights]
    assert isinstance(axes.figure, Figure)
    axes.figure.draw_without_rendering()
    assert {text.get_text() for text in axes.get_yticklabels(minor=True)} <= {""}
    assert all(float(text.get_text()) > 0.0 for text in axes.get_yticklabels())


def test_a_thinned_trace_keeps_its_nearest_point() -> None:
    times_s = np.arange(10_000.0)
    apart_m = np.full(10_000, 1.0)
    apart_m[7_777], apart_m[:100] = 0.01, np.nan
    kept_s, kept_m = thinned(times_s, apart_m)
    assert len(kept_s) <= POINTS_MAX
    assert (kept_s[np.nanargmin(kept_m)], np.nanmin(kept_m)) == (7_777.0, 0.01)


def test_dead_robots_and_their_successors_are_marked_at_their_places(folder: Path) -> None:
    drawn = course(folder / "killed")
    assert list(drawn.dead) == [1]
    region = chart(drawn, "region")
    said = words(region)
    assert "dead body" in said
    assert "leads from here" in said
    crosses = [line for line in painted(region)[0].lines if line.get_marker() == "x"]
    assert [tuple(np.asarray(line.get_xydata())[0]) for line in crosses] == [tuple(drawn.places_m[-1, 0])]
    assert "succession" in words(chart(drawn, "clearance"))


def test_a_run_without_a_way_shows_where_the_leader_stood(folder: Path) -> None:
    drawn = course(folder / "closed")
    assert "no way on" in words(chart(drawn, "region"))
    left_out = [each.name for each in charts_of(drawn) if isinstance(each, LeftOut)]
    assert left_out == ["steps", "distances"]


def test_every_switching_step_has_a_panel_with_the_chosen_gap(folder: Path) -> None:
    drawn = course(folder / "paper")
    panels = [axes for axes in painted(chart(drawn, "steps")) if axes.get_title()]
    assert len(panels) == len(drawn.steps) == 10
    for axes, planned in zip(panels, drawn.steps, strict=True):
        assert planned.plan.gap is not None
        (gap,) = (line for line in axes.lines if line.get_linestyle() == "--")
        width_m = np.hypot(*np.diff(np.asarray(gap.get_xydata()), axis=0)[0])
        assert width_m == pytest.approx(planned.plan.gaps[planned.plan.gap].width_m, abs=1e-6)


@pytest.mark.parametrize("name", ["killed", *long(["paper", "pedestrian"])])
def test_panels_of_steps_fill_most_of_the_page(folder: Path, name: str) -> None:
    drawn = chart(course(folder / name), "steps")
    figure = Figure(figsize=drawn.size_in, layout="constrained")
    drawn.paint(figure)
    figure.draw_without_rendering()
    panels = [axes for axes in figure.axes if axes.get_title()]
    first = figure.axes[0].get_subplotspec()
    assert first is not None
    wide = sum(axes.get_position().width for axes in panels[: first.get_gridspec().ncols])
    assert wide > 0.9
    scales = [(axes.get_xlabel(), axes.get_ylabel()) for axes in panels]
    assert scales[0][1] == "y [m]"
    assert scales[-1][0] == "x [m]"
    assert all(axes.axison and len(axes.get_xticks()) > 1 for axes in panels)


def test_figures_are_as_wide_as_columns_and_say_their_units(folder: Path) -> None:
    for each in charts_of(course(folder / "killed")):
        assert isinstance(each, Chart)
        width_in, _ = each.size_in
        assert width_in in (COLUMN_IN, PAGE_IN)
        svg = ET.fromstring(render(each, ("svg",))["svg"])
        assert svg.get("width") == f"{72.0 * width_in:g}pt"
        assert "[m]" in "".join(svg.itertext())


@pytest.fixture(scope="module")
def told(folder: Path) -> dict[str, Any]:
    """What the verb says of the figures that it has written: of a run without a way, in all formats."""
    said: dict[str, Any] = json.loads(clew("figures", folder / "closed", "--json").stdout)
    return said


def test_files_are_valid_and_hold_text_not_outlines(folder: Path, told: dict[str, Any]) -> None:
    drawn = [each for each in charts_of(course(folder / "closed")) if isinstance(each, Chart)]
    assert len(told["written"]) == len(drawn) * len(FORMATS)
    for each in drawn:
        file = folder / "closed" / "figures" / each.name
        files = {form: file.with_suffix(f".{form}").read_bytes() for form in FORMATS}
        width_in, _ = each.size_in
        assert files["pdf"].startswith(b"%PDF-")
        assert files["pdf"].rstrip().endswith(b"%%EOF")
        assert b"/Subtype /Type3" not in files["pdf"]
        assert files["png"].startswith(b"\x89PNG")
        assert int.from_bytes(files["png"][16:20]) == int(300.0 * width_in)


def test_figures_of_ours_are_replaced_and_no_other_file(
    folder: Path, tmp_path: Path, told: dict[str, Any]
) -> None:
    for path in map(Path, told["written"]):
        check_ours(path, MARK.encode())
    asked = ("figures", folder / "closed", "--format", "svg", "--out", tmp_path)
    assert clew(*asked).exit_code == 0
    drawn = {path: path.read_bytes() for path in tmp_path.iterdir()}
    mine = min(drawn)
    mine.write_bytes(b"mine")
    said = clew(*asked)
    refusal = f"Error: cannot write {mine}: it is there, and bears no mark of Clew, so it would be lost"
    assert (said.exit_code, said.stderr.splitlines()[-1]) == (2, refusal)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == {**drawn, mine: b"mine"}
    mine.unlink()
    assert clew(*asked).exit_code == 0
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == drawn


@pytest.mark.long
def test_the_same_run_gives_the_same_bytes_in_another_process_and_with_any_user_settings(
    folder: Path, tmp_path: Path
) -> None:
    asked: list[str | Path] = ["figures", folder / "pedestrian", "--format", "svg, pdf", "--out"]
    assert clew(*asked, tmp_path / "here").exit_code == 0
    (tmp_path / "matplotlibrc").write_text("lines.linewidth: 9\nsavefig.bbox: tight\n", encoding="utf-8")
    subprocess.run(
        [sys.executable, "-m", "clew.cli", *asked, tmp_path / "there"],
        env=os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": str(ROOT), "MATPLOTLIBRC": str(tmp_path)},
        timeout=DEADLINE_S,
        check=True,
        capture_output=True,
    )
    names = sorted(path.name for path in (tmp_path / "here").iterdir())
    assert len(names) == 10
    for name in names:
        here, there = (tmp_path / where / name for where in ("here", "there"))
        assert here.read_bytes() == there.read_bytes(), name


def test_figures_are_written_into_the_runs_folder_and_every_file_is_named(
    folder: Path, told: dict[str, Any]
) -> None:
    assert told["left_out"].keys() == {"steps", "distances"}
    assert {Path(path).suffix for path in told["written"]} == {".svg", ".pdf", ".png"}
    assert all(Path(path).parent == folder / "closed" / "figures" for path in told["written"])
    assert all(Path(path).exists() for path in told["written"])


def test_a_figure_does_not_change_matplotlibs_settings(folder: Path) -> None:
    before = dict(mpl.rcParams)
    render(chart(course(folder / "closed"), "region"), ("svg",))
    assert dict(mpl.rcParams) == before
