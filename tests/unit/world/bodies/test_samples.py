"""What the samples of poses tell of distances, by an independent measurement."""

import math
from collections import defaultdict

import pytest
import shapely
from msgspec.structs import replace

from clew.bench.forming import SPACING_M, queue
from clew.log import timeline
from clew.log.check import scenario_of
from protocol.timeline import PoseSampled
from tests.support.runs import Runs
from tests.support.strategies.shape_strategies import as_shapely
from world.bodies.arena import TICK_S, Arena
from world.bodies.guard import SMALL_FLEET
from world.judge.truth.track import Track
from world.record.resume import QUIET_S
from world.scenario.scenario import load

ROUNDED_M = 1e-6  # half a micrometre of rounding, and as much of where the others are between two samples


def test_every_sample_tells_the_clearance_and_the_separation_of_its_hull(runs: Runs) -> None:
    read = timeline.read(runs.of("grove"))
    scenario, tracks = scenario_of(read), defaultdict[int, Track](Track)
    samples = [(entry.t_s, entry.record) for _, entry in read.lines if isinstance(entry.record, PoseSampled)]
    for t_s, pose in samples:
        tracks[pose.robot].hear(t_s, pose)
    shapes = [as_shapely(shape) for shape in scenario.obstacles]
    radius_m = scenario.fleet.robot_radius_m
    assert len(samples) > 500
    for t_s, pose in samples:
        here = shapely.Point(pose.x_m, pose.y_m)
        clear_m = min(shape.distance(here) for shape in shapes) - radius_m
        others = [track.at(t_s) for other, track in tracks.items() if other != pose.robot]
        apart_m = min(math.hypot(each.x_m - pose.x_m, each.y_m - pose.y_m) for each in others if each)
        assert pose.clearance_m == pytest.approx(clear_m, abs=ROUNDED_M)
        assert pose.separation_m == pytest.approx(apart_m - 2.0 * radius_m, abs=ROUNDED_M)


def test_without_obstacles_and_others_there_is_nothing_to_measure_to() -> None:
    alone = replace(load("grove", robots=1), obstacles=())
    [sampled] = Arena(alone, seed=1).sample()
    assert isinstance(sampled.record, PoseSampled)
    assert (sampled.record.clearance_m, sampled.record.separation_m) == (None, None)


@pytest.mark.parametrize("robots", [2, SMALL_FLEET + 1])
def test_while_all_stand_one_body_is_sampled_each_second(robots: int) -> None:
    arena = Arena(queue(robots), seed=1)
    arena.place()
    notes = [note.record for _ in range(round(1.5 * QUIET_S / TICK_S)) for note in arena.tick()[0]]
    [sampled] = [each for each in notes if isinstance(each, PoseSampled)]
    apart_m = SPACING_M - 2.0 * queue(robots).fleet.robot_radius_m
    assert sampled.robot == 1
    assert sampled.separation_m == pytest.approx(apart_m)
