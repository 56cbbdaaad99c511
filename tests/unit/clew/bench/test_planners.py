"""The planners of others that `clew bench plan` measures: they plan what they are known for."""

from collections.abc import Sequence
from importlib import import_module

import numpy as np
import pytest

from clew.bench.plan import Planner, Sample, common, figures, peer_plan
from clew.bench.planners import growing
from clew.bench.planners.growing import field, samples, views
from clew.bench.planners.window import PERIOD_S, Window
from protocol.frames import Point
from protocol.mission import Mission
from tests.support.stages.one_step import look_around, under, wall
from world.geometry.shapes import Shape

MISSION = under("certified", robot_radius_m=0.1, goal=Point(x_m=3.0, y_m=0.0), directions=360)
STRAIGHT_M = MISSION.speed_mps * PERIOD_S


@pytest.fixture(params=["window", "orca"])
def planner(request: pytest.FixtureRequest) -> Planner:
    """ORCA only where the extra `peers` is installed."""
    if request.param == "window":
        return Window(MISSION)
    pytest.importorskip("pyrvo")
    made: Planner = import_module("clew.bench.planners.orca").Orca(MISSION)
    return made


def driven_m(planner: Planner, shapes: Sequence[Shape], mission: Mission = MISSION) -> float:
    return planner.plan(look_around(shapes, mission))


def test_on_open_ground_it_drives_at_full_speed(planner: Planner) -> None:
    assert driven_m(planner, []) == pytest.approx(STRAIGHT_M, rel=0.01)


def test_it_drives_no_faster_towards_a_wall_that_is_near(planner: Planner) -> None:
    near = wall((0.3, 2.0), (0.3, -2.0))
    assert driven_m(planner, [near]) < 0.9 * STRAIGHT_M


def test_a_window_in_which_nothing_is_clear_drives_nowhere() -> None:
    around: list[Shape] = [wall((x, -0.15), (x, 0.15)) for x in (-0.15, 0.15)]
    assert driven_m(Window(MISSION), around) == 0.0


def test_a_peers_metres_are_those_that_it_drives_and_stand_beside_ours() -> None:
    took_s, planned_m = peer_plan(Window(MISSION), look_around([], MISSION), iter((1.0, 1.5)).__next__)
    assert took_s == 0.5
    assert planned_m == pytest.approx(STRAIGHT_M, rel=0.01)
    parts_s = {"perceive": 0.0, "certify": 0.0, "guide": 0.0, "record": 0.0}
    found = [Sample(0.001, 0.001, parts_s, 0.002, 1.0, {"peer": (0.004, 0.05)})] * 3
    plan, metre, *_ = common("one", [figures(["one"], found)])
    assert [each.name for each in plan.baselines] == ["textbook", "peer"]
    assert plan.baselines[1].ratio.median == pytest.approx(0.25)
    assert metre.baselines[1].measured.median == pytest.approx(80.0)


@pytest.mark.long
def test_a_map_that_grows_has_the_scans_that_are_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(growing, "PLANS", 2)
    scenario = field()
    seen = views(scenario, 4)
    middle_off_m = [float(np.hypot(*(each.position - 15.0))) for each in seen]
    assert middle_off_m == sorted(middle_off_m)
    assert scenario.mission().bounds is None
    ticks = iter(range(10_000))
    found = samples(scenario, seen, 4, cpu=lambda: float(next(ticks)))
    assert len(found) == 2
    assert all((each.cpu_s, each.textbook_s) == (1.0, 1.0) and each.step_m > 0.0 for each in found)
    told = figures(["a map"], found)
    assert told.plan_cpu == told.textbook_cpu
