"""The batches of a run: complete, faithful to the log, with the same distances as the monitor."""

import json
import re
from collections import Counter, defaultdict
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from clew.log import timeline
from clew.log.check import scenario_of
from clew.log.timeline import Timeline
from clew.page.batch import PLACE_TOLERANCE_M
from clew.page.batches import Batches
from clew.story import distances
from protocol.timeline import KINDS, Entry, LinkBroken, OrderAccepted, PoseSampled, kind_of
from tests.support.pages.pages import column, told
from tests.support.planned import planned
from tests.support.runs import Runs
from world.judge.table import measure
from world.judge.tally import Tally
from world.record.run_files import read_verdict


@pytest.fixture(scope="module")
def killed(runs: Runs) -> Path:
    """A run with a killed leader: a death, broken links, a succession, a heal."""
    return runs.of("grove", faults="leader-killed")


@pytest.fixture(scope="module")
def read(killed: Path) -> Timeline:
    return timeline.read(killed)


@pytest.fixture(scope="module")
def batches(killed: Path) -> list[dict[str, Any]]:
    return told(killed)


def test_the_minima_of_the_curves_are_the_verdicts(killed: Path, batches: list[dict[str, Any]]) -> None:
    verdict = read_verdict(killed)
    clear_m = [each for batch in batches for one in batch["clearances"] for each in column(one["least"], 1e4)]
    apart_m = [each for batch in batches for each in column(batch["separations"]["least"], 1e4)]
    assert verdict.clearance_m_min is not None
    assert verdict.separation_m_min is not None
    assert min(clear_m) == pytest.approx(verdict.clearance_m_min, abs=0.5e-4)
    assert min(apart_m) == pytest.approx(verdict.separation_m_min, abs=0.5e-4)


def test_thinned_curves_keep_their_minima(
    killed: Path, batches: list[dict[str, Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(distances, "CURVE_POINTS", 100)
    [thin], [whole] = told(killed), batches
    for few, many in zip(thin["clearances"], whole["clearances"], strict=True):
        assert min(column(few["least"], 1e4)) == min(column(many["least"], 1e4))
    kept, all_there = (sum(len(each["t"]) for each in batch["clearances"]) for batch in (thin, whole))
    assert kept < 0.5 * all_there
    apart = [batch["separations"] for batch in (thin, whole)]
    assert min(column(apart[0]["least"], 1e4)) == min(column(apart[1]["least"], 1e4))
    assert len(apart[0]["t"]) == len(apart[0]["robot"]) == len(apart[0]["other"]) <= 100


def test_passings_of_a_moving_obstacle_have_the_verdicts_minimum(runs: Runs) -> None:
    run = runs.of("pedestrian")
    passed_m = [each for batch in told(run) for each in column(batch["passings"]["least"], 1e4)]
    verdict = read_verdict(run)
    assert verdict.moving_clearance_m_min is not None
    assert min(passed_m) == pytest.approx(verdict.moving_clearance_m_min, abs=0.5e-4)


def test_every_entry_except_poses_is_in_the_batches_once_with_all_its_fields(
    read: Timeline, batches: list[dict[str, Any]]
) -> None:
    in_log = Counter(kind_of(entry.record) for _, entry in read.lines)
    del in_log["pose.sampled"]
    told_of: Counter[str] = Counter()
    indices: list[float] = []
    for batch in batches:
        for kind, columns in batch["entries"].items():
            told_of[kind] += len(columns["t"])
            indices += column(columns["i"], 1.0)
            assert {len(each) for each in columns.values()} == {len(columns["t"])}
    assert told_of == in_log
    assert len(set(indices)) == len(indices)
    orders = [(source, entry) for source, entry in read.lines if isinstance(entry.record, OrderAccepted)]
    [columns] = [batch["entries"]["order.accepted"] for batch in batches]
    assert column(columns["t"], 1e3) == pytest.approx([entry.t_s for _, entry in orders], abs=0.5e-3)
    assert columns["source"] == [source for source, _ in orders]
    fields = {"robot", "number", "epoch", "turn", "life", "step", "x_m", "y_m", "target", "reach_m"}
    assert set(columns) == {"i", "t", "source", *fields}


def test_bodies_are_at_the_poses_of_the_log(read: Timeline, batches: list[dict[str, Any]]) -> None:
    samples: defaultdict[int, list[tuple[float, float, float]]] = defaultdict(list)
    for _, entry in read.lines:
        if isinstance(entry.record, PoseSampled):
            samples[entry.record.robot].append((entry.t_s, entry.record.x_m, entry.record.y_m))
    [batch] = batches
    kept = 0
    for track in batch["tracks"]:
        t_s, x_m, y_m = np.array(samples[track["robot"]]).T
        shown_s = column(track["t"], 1e3)
        kept += len(shown_s)
        for axis, in_log_m in (("x", x_m), ("y", y_m)):
            shown_m = np.interp(t_s, shown_s, column(track[axis], 1e3))
            assert np.abs(shown_m - in_log_m).max() < PLACE_TOLERANCE_M
    assert kept < 0.7 * sum(map(len, samples.values()))


@pytest.mark.parametrize("in_pieces", [False, True])
def test_a_body_stands_until_it_turns(*, in_pieces: bool) -> None:
    making, t_s, heading_rad = Batches(None), list[float](), list[float]()
    for number, (at_s, turned_rad) in enumerate([(0.0, 0.0), (2.0, 0.15), (2.1, 0.3)], start=1):
        pose = PoseSampled(robot=1, x_m=0.0, y_m=0.0, heading_rad=turned_rad)
        making.hear("world", Entry(n=number, t_s=at_s, hlc="0/world", record=pose))
        if in_pieces or number == 3:
            [track] = json.loads(making.batch() or b"")["tracks"]
            t_s += column(track["t"], 1e3)
            heading_rad += column(track["heading"], 1e3)
    assert np.interp([1.8, 2.05], t_s, heading_rad).tolist() == [0.0, pytest.approx(0.225)]


def joined(curves: list[dict[str, Any]]) -> list[tuple[float, float]]:
    """The pieces of a curve joined: times and distances."""
    return [
        point
        for curve in curves
        for point in zip(column(curve["t"], 1e3), column(curve["least"], 1e4), strict=True)
    ]


def test_a_run_in_pieces_equals_the_run_as_a_whole(read: Timeline, batches: list[dict[str, Any]]) -> None:
    making, pieces = Batches(read.header), []
    for place, (source, entry) in enumerate(read.lines):
        making.hear(source, entry)
        if place % 100 == 0:
            pieces.append(json.loads(making.batch() or b""))
    pieces.append(json.loads(making.batch(ended=True) or b""))
    whole = batches[0]
    for field in ("lanes", "links", "strands"):
        assert [each for piece in pieces for each in piece.get(field, ())] == whole[field]
    steps = {step["place"]: step for piece in pieces for step in piece.get("steps", ())}
    assert list(steps.values()) == whole["steps"]
    assert [piece["books"] for piece in pieces if "books" in piece][-1] == whole["books"]
    assert {epoch: path for piece in pieces for epoch, path in piece.get("paths", {}).items()} == whole[
        "paths"
    ]
    apart = [piece["separations"] for piece in pieces if "separations" in piece]
    assert joined(apart) == joined([whole["separations"]])
    for robot in range(1, 6):
        clear = [each for piece in pieces for each in piece.get("clearances", ()) if each["robot"] == robot]
        assert joined(clear) == joined([each for each in whole["clearances"] if each["robot"] == robot])
    assert [piece for piece in pieces if "subject" in piece] == pieces[:1]


def test_nothing_new_makes_no_batch(read: Timeline) -> None:
    told_of = Batches(read.header)
    assert told_of.batch() is not None
    assert told_of.batch() is None


def test_lanes_and_links_show_the_death(read: Timeline, batches: list[dict[str, Any]]) -> None:
    [batch] = batches
    first = [lane["state"] for lane in batch["lanes"] if lane["robot"] == 1]
    second = [lane["state"] for lane in batch["lanes"] if lane["robot"] == 2]
    assert first == ["lining up", "free", "dead"]
    assert second[:3] == ["lining up", "free", "lining up"]
    assert second[-1] == "arrived"
    broken_s = next(entry.t_s for _, entry in read.lines if isinstance(entry.record, LinkBroken))
    assert {"one": 1, "other": 2, "t_s": broken_s, "state": "broken"} in batch["links"]
    assert [strand["order"][0] for strand in batch["strands"]][:2] == [1, 2]


def test_steps_end_at_the_switching_positions(read: Timeline, batches: list[dict[str, Any]]) -> None:
    tally = Tally()
    for source, entry in read.lines:
        tally.hear(source, entry)
    [batch] = batches
    start, *stood = tally.switching_positions
    finished = [step for step in batch["steps"] if step["end"] == "finished"]
    assert [(step["x_m"], step["y_m"]) for step in finished] == [(place.x_m, place.y_m) for place in stood]
    assert [step["position"] for step in finished] == list(range(1, len(stood) + 1))
    scenario = scenario_of(read)
    rows = measure(scenario, [start, *stood])
    assert [batch["start"]["distances_m"], *(step["distances_m"] for step in finished)] == [
        pytest.approx(row) for row in rows
    ]


def test_a_step_that_promises_too_little_is_marked_as_leading_away(read: Timeline) -> None:
    making = Batches(read.header)
    near = replace(planned(1), promised_clearance_m=0.05)
    for number, plan in enumerate((near, replace(near, step=2, promised_clearance_m=0.1)), start=1):
        making.hear("r1", Entry(n=number, t_s=float(number), hlc="0/r1", record=plan))
    batch = json.loads(making.batch() or b"")
    assert [step["leads_away"] for step in batch["steps"]] == [True, False]
    assert ["leads away" in said for said in batch["entries"]["step.planned"]["says"]] == [True, False]


def test_each_moment_has_a_sign_and_a_sentence(batches: list[dict[str, Any]]) -> None:
    script = (files("clew.page") / "assets" / "run" / "moments.js").read_text(encoding="utf-8")
    signs = set(re.findall(r'^  "([a-z.]+)": \{ sign', script, re.MULTILINE))
    assert signs <= KINDS.keys()
    [batch] = batches
    assert all("says" in columns for kind, columns in batch["entries"].items() if kind in signs)
    assert "r2 plans step 2: " in " ".join(batch["entries"]["step.planned"]["says"])
