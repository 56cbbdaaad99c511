"""The scene that ir-sim simulates is that of the rehearsal."""

import math

import pytest

from clew.bench.forming import queue
from clew.bench.peer import CORNERS, STEP_S, stepper, world_of
from world.scenario.scenario import load


def test_it_has_the_same_robots_and_obstacles() -> None:
    grove = load("grove")
    world = world_of(grove)
    assert [robot["state"] for robot in world["robot"]] == [
        [pose.x_m, pose.y_m, pose.heading_rad] for pose in grove.fleet.poses()
    ]
    assert {tuple(robot["goal"]) for robot in world["robot"]} == {(5.5, 2.1, 0.0)}
    assert len(world["obstacle"]) == len(grove.obstacles)
    assert (world["world"]["width"], world["world"]["height"]) == (6.0, 4.0)


def test_an_ellipse_is_a_polygon_on_its_outline() -> None:
    (x_m, y_m), (a_m, b_m), turned_rad = (3.1, 0.45), (0.4, 0.22), 0.4
    corners = world_of(load("grove"))["obstacle"][3]["shape"]["vertices"]
    assert len(corners) == CORNERS
    for corner_x_m, corner_y_m in corners:
        off_x, off_y = corner_x_m - x_m, corner_y_m - y_m
        along = math.cos(turned_rad) * off_x + math.sin(turned_rad) * off_y
        across = math.cos(turned_rad) * off_y - math.sin(turned_rad) * off_x
        assert math.hypot(along / a_m, across / b_m) == pytest.approx(1.0)


def test_it_simulates_so_many_seconds() -> None:
    irsim = pytest.importorskip("irsim", reason="the extra `peers` is not installed")
    steps = []
    step = irsim.env.EnvBase.step
    irsim.env.EnvBase.step = lambda env: steps.append(step(env))
    try:
        stepper(queue(2))(1.0)
    finally:
        irsim.env.EnvBase.step = step
    assert len(steps) == round(1.0 / STEP_S)
