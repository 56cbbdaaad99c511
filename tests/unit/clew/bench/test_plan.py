import itertools
import json
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from agents.navigation.guidance import CELLS_PER_KEEP
from agents.navigation.scan import View
from agents.strand.leader import Leader
from clew.bench.plan import PARTS, SEED, Sample, Stopwatch, common, figures, samples
from clew.bench.planners.textbook import Textbook
from clew.bench.planners.window import Window
from clew.rehearsal.rehearsal import Rehearsal
from protocol.arrays import Floats, scan_bearings_rad
from protocol.root import ROOT
from protocol.timeline import StepPlanned
from tests.support.campaigns import WALL, clew, scene
from world.scenario.scenario import load

RAYS = 360


def ticking() -> Callable[[], float]:
    """A clock that goes on by a second whenever it is read."""
    return map(float, itertools.count()).__next__


def test_only_the_outermost_of_nested_functions_is_timed() -> None:
    watch = Stopwatch(ticking())
    inner = watch.timed("inner", lambda: "done")
    assert watch.timed("outer", lambda: (inner(), inner()))() == ("done", "done")
    assert dict(watch.spent_s) == {"outer": 1.0}
    inner()
    assert dict(watch.spent_s) == {"outer": 1.0, "inner": 1.0}


def test_a_function_that_raises_is_timed_too() -> None:
    watch = Stopwatch(ticking())
    failing = watch.timed("failing", lambda: 1 // 0)
    for seconds in (1.0, 2.0):
        with pytest.raises(ZeroDivisionError):
            failing()
        assert watch.spent_s["failing"] == seconds


def test_every_plan_of_a_rehearsal_is_a_sample_whose_parts_add_up_to_at_most_the_whole(
    tmp_path: Path,
) -> None:
    scenario = load(str(scene(tmp_path / "beside.json", polygons=[WALL], bounds=[0.0, -1.0, 6.0, 3.0])))
    found = samples(scenario, cpu=ticking(), wall=ticking(), peers={"peer": Window})
    entries = Rehearsal(scenario, SEED).run().entries
    assert len(found) == sum(isinstance(entry.record, StepPlanned) for _, entry in entries) > 1
    for sample in found:
        assert sample.parts_s.keys() == PARTS.keys()
        assert 0.0 < sum(sample.parts_s.values()) < sample.cpu_s
        assert min(sample.textbook_s, sample.wall_s, *sample.parts_s.values()) > 0.0
        assert sample.peers["peer"][0] == 1.0, "a tick of the clock"
        assert sample.peers["peer"][1] > 0.0, "it drives"


def interrupted_at(reading: int) -> Callable[[], float]:
    """A clock during whose so-manieth reading somebody presses Ctrl-C: the third is within the first plan."""
    readings = itertools.count(1)

    def clock() -> float:
        if (now := next(readings)) == reading:
            raise KeyboardInterrupt
        return float(now)

    return clock


def test_the_leader_is_restored_even_if_a_rehearsal_is_interrupted(tmp_path: Path) -> None:
    before = [getattr(owner, name) for functions in PARTS.values() for owner, name in functions], Leader.plan
    scenario = load(str(scene(tmp_path / "near.json")))
    with pytest.raises(KeyboardInterrupt):
        samples(scenario, cpu=interrupted_at(3), wall=ticking())
    samples(scenario, cpu=ticking(), wall=ticking())
    after = [getattr(owner, name) for functions in PARTS.values() for owner, name in functions], Leader.plan
    assert before == after


def test_figures_are_median_90th_percentile_and_maximum_in_milliseconds() -> None:
    parts_s = dict.fromkeys(PARTS, 0.001)
    found = figures(["one"], [Sample(n / 1000.0, 2.0 * n / 1000.0, parts_s, 0.002) for n in range(11)])
    assert (found.plans, list(found.scenes)) == (11, ["one"])
    for spread, expected_ms in ((found.plan_cpu, (5.0, 9.0, 10.0)), (found.plan_wall, (10.0, 18.0, 20.0))):
        assert (spread.median_ms, spread.p90_ms, spread.max_ms) == pytest.approx(expected_ms)


def test_the_common_figures_have_a_repeat_for_each_run_and_divide_by_the_metres_that_were_planned() -> None:
    parts_s = dict.fromkeys(PARTS, 0.001)
    runs = [figures(["one"], [Sample(cpu_s, 1.0, parts_s, 0.002, 0.5)] * 4) for cpu_s in (0.001, 0.003)]
    plan, metre, *parts = common("360 directions", runs)
    assert (plan.measured.repeats, plan.measured.most) == (2, 3.0)
    assert (plan.baselines[0].ratio.least, plan.met) == (0.5, True)
    assert (metre.measured.most, metre.baselines[0].measured.most) == (6.0, 4.0)
    assert [(each.name, each.measured.most) for each in parts] == [
        (f"360 directions: {part}", 1.0) for part in PARTS
    ]


def textbook_cost_at_start(path: Path, hit_points: Floats) -> float:
    """Of the way of 2 m, after a scan that hits these points and nothing else."""
    scenario = load(str(path))
    mission = scenario.mission()
    off = hit_points - np.array([2.0, 0.0])
    ranges_m, hits = np.full(RAYS, mission.range_m_max), np.zeros(RAYS, dtype=np.bool_)
    rays = np.round((np.arctan2(off[:, 1], off[:, 0]) + np.pi) / (2.0 * np.pi) * RAYS).astype(int) % RAYS
    ranges_m[rays], hits[rays] = np.hypot(off[:, 0], off[:, 1]), True
    view = View(np.array([2.0, 0.0]), scan_bearings_rad(RAYS), ranges_m, hits, t_s=0.0)
    cell_m = mission.obstacle_keep_m / CELLS_PER_KEEP
    cost = Textbook(mission).plan(view)
    return float(cost[int(2.0 / cell_m), int(1.0 / cell_m)])


def test_the_textbook_planner_goes_straight_on_open_ground_and_never_through_a_wall(tmp_path: Path) -> None:
    path = scene(tmp_path / "open.json")
    wall = np.column_stack([np.full(400, 3.0), np.linspace(-1.0, 0.999, 400)])
    assert textbook_cost_at_start(path, np.empty((0, 2))) == pytest.approx(2.0, abs=0.1)
    assert textbook_cost_at_start(path, wall) == math.inf
    assert 2.1 < textbook_cost_at_start(path, wall[wall[:, 1] < 0.3]) < 3.0


def test_bench_plan_times_every_part_for_the_named_scenes(tmp_path: Path) -> None:
    path = scene(tmp_path / "near.json", goal=[5.0, 0.0])
    result = json.loads(clew("bench", "plan", "--scenes", path, "--json").stdout)
    (said,) = result["details"]
    assert result["figures"][0]["measured"]["median"] == said["plan_cpu"]["median_ms"]
    assert said["scenes"] == [str(path)]
    assert said["parts_cpu"].keys() == PARTS.keys()
    for spread in (said["plan_cpu"], said["plan_wall"], said["textbook_cpu"], *said["parts_cpu"].values()):
        assert 0.0 <= spread["median_ms"] <= spread["p90_ms"] <= spread["max_ms"]
    for_people = clew("bench", "plan", "--scenes", path)
    assert "as the scenes are: certify" in for_people.stdout
    assert "the textbook planner" in for_people.stdout


def test_bench_plan_refuses_a_scenario_without_a_goal() -> None:
    refusal = clew("bench", "plan", "--scenes", ROOT / "launch/scenarios/paper.toml")
    assert refusal.exit_code == 2
    assert "has no goal" in refusal.stderr
