import json
from pathlib import Path
from typing import Any

import pytest

from protocol.errors import UsageError
from world.geometry.moving import MovingCircle
from world.geometry.shapes import Circle, Polygon
from world.scenario.scenario import Scenario, load

SCENE: dict[str, Any] = {
    "schema": "clew-scene/1",
    "name": "posts",
    "family": "test",
    "start": [-2.0, 0.0, 0.0],
    "goal": [3.0, 0.0],
    "goal_tol": 0.5,
    "robot_radius": 0.12,
    "bounds": [-4.0, -2.0, 4.0, 2.0],
    "circles": [[0.0, 0.0, 0.075], [0.0, 0.15, 0.075]],  # two posts that touch
    "polygons": [[[1.0, 0.5], [1.5, 0.5], [1.5, 1.0], [1.0, 1.0]]],
    "walls": [[[-4.0, -2.0], [4.0, -2.0], [4.0, -1.8], [-4.0, -1.8]]],
    "stats": {"widest_path_radius": 0.5},
}


def _load(
    tmp_path: Path, changes: dict[str, Any], robots: int | None = None, law: str | None = None
) -> Scenario:
    path = tmp_path / "posts.json"
    path.write_text(json.dumps({key: value for key, value in (SCENE | changes).items() if value is not None}))
    return load(str(path), robots=robots, law=law)


def test_a_scene_becomes_a_certified_scenario_with_five_robots(tmp_path: Path) -> None:
    posts = _load(tmp_path, {})
    assert posts.law.law == "certified"
    assert [type(obstacle) for obstacle in posts.obstacles] == [Circle, Circle, Polygon, Polygon]
    places = [(pose.x_m, pose.y_m) for pose in posts.fleet.poses()]
    expected = [(-2.0 - k * 3 * 0.12, 0.0) for k in range(5)]
    assert [x_m for x_m, _ in places] == pytest.approx([x_m for x_m, _ in expected])
    assert posts.goal is not None
    assert (posts.goal.at_m, posts.goal.tolerance_m) == ((3.0, 0.0), 0.5)
    assert posts.bounds is not None
    assert posts.bounds.y_m_max == 2.0


def test_a_scene_may_omit_walls_and_run_with_fewer_robots(tmp_path: Path) -> None:
    assert len(_load(tmp_path, {"walls": None}).obstacles) == 3
    assert _load(tmp_path, {}, robots=2, law="printed").fleet.robots == 2


def test_a_scene_may_name_metres_as_units_and_have_no_circles(tmp_path: Path) -> None:
    assert len(_load(tmp_path, {"units": "m", "circles": []}).obstacles) == 2


def test_robots_start_further_apart_where_discs_are_fast(tmp_path: Path) -> None:
    spacings_m = []
    for end_m in (2.0, 0.0):  # 0.5 m/s, and 2.5 m/s
        track = [[0, 2.5, 2.5], [1, 2.5, end_m]]
        fleet = _load(tmp_path, {"moving": [{"id": 7, "radius": 0.2, "track": track}]}).fleet
        spacings_m.append(fleet.spacing_m)
    assert spacings_m == pytest.approx([0.36, 2.0 * 0.12 + 0.06 * 2.5 + 3.0 * 0.005])


def test_a_scene_may_have_moving_discs_with_numbers_as_names(tmp_path: Path) -> None:
    track = [[0, 2.0, -1.0], [4, 2.0, 1.0], [6, 2.0, -1.0]]
    crossed = _load(tmp_path, {"moving": [{"id": 7, "radius": 0.2, "track": track}]})
    (mover,) = crossed.moving
    assert isinstance(mover, MovingCircle)
    assert (mover.id, mover.radius_m, mover.track[1]) == ("7", 0.2, (4.0, 2.0, 1.0))
    assert crossed.mission().obstacle_speed_mps_max == 1.0
    assert _load(tmp_path, {}).mission().obstacle_speed_mps_max == 0.0


def test_the_heading_of_the_start_may_be_any_angle(tmp_path: Path) -> None:
    assert _load(tmp_path, {"start": [-2.0, 0.0, 6.283185307179586]}).fleet.poses()[0].heading_rad == 0.0


def test_the_time_limit_is_for_the_longest_way_that_fits_into_the_ground(tmp_path: Path) -> None:
    width_m = 2.0 * (0.12 + 0.05)
    winding_m = 8.0 * 4.0 / (2.0 * width_m)  # walls are as wide as ways
    assert _load(tmp_path, {}).time.time_s_max == pytest.approx(8.0 * winding_m / 0.5)


def test_a_narrow_ground_has_time_for_the_straight_way(tmp_path: Path) -> None:
    lane = {"bounds": [-4.0, -0.3, 40.0, 0.3], "goal": [38.0, 0.0], "circles": [], "polygons": []}
    assert _load(tmp_path, {**lane, "walls": None}).time.time_s_max == pytest.approx(8.0 * 40.0 / 0.5)


def test_a_scene_or_the_caller_may_say_the_time_limit(tmp_path: Path) -> None:
    assert _load(tmp_path, {"time_s_max": 77.0}).time.time_s_max == 77.0
    path = tmp_path / "posts.json"
    assert load(str(path), time_s_max=88.0).time.time_s_max == 88.0
    with pytest.raises(UsageError, match=r"time_s_max: must be > 0.0 s, got -1.0 .*time_s_max = -1.0"):
        load(str(path), time_s_max=-1.0)
    with pytest.raises(UsageError, match=r"\$.time_s_max: must be > 0.0 s, got 0"):
        _load(tmp_path, {"time_s_max": 0})


@pytest.mark.parametrize("corner_m", [0.5, 0.1, 0.05])
def test_noise_and_drive_errors_use_half_of_the_tolerance_for_any_corners(
    tmp_path: Path, corner_m: float
) -> None:
    sharp = {"polygons": [[[1.0, 0.5], [1.5, 0.5 - corner_m], [1.5, 0.5 + corner_m]]]}
    scenario = _load(tmp_path, sharp)
    assert scenario.error_budget.total_m == pytest.approx(scenario.law.mu0_m / 2, rel=0.05)


def test_the_range_of_a_large_robot_scales_with_its_radius(tmp_path: Path) -> None:
    large = {
        "robot_radius": 1.0,
        "start": [-20.0, 0.0, 0.0],
        "goal": [20.0, 0.0],
        "bounds": [-40.0, -40.0, 40.0, 40.0],
        "walls": None,
    }
    assert _load(tmp_path, large).sensor.range_m_max == 20.0


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"schema": "clew-scene/2"}, "$.schema: must be 'clew-scene/1', got 'clew-scene/2'"),
        ({"goal": None}, "$: must have the field goal, got schema, name, family, start, goal_tol, "),
        ({"robot_radius": -0.1}, "$.robot_radius: must be > 0.0, got -0.1"),
        (
            {"circles": [[0.0, 0.0, 0.1], [0.0, 1.0]]},
            "$.circles[1]: must be a list of length 3, got [0.0, 1.0]",
        ),
        (
            {"polygons": [[[0, 0], [1, 1], [1, 0], [0, 1]]]},
            "$.polygons[0]: vertices_m must make a simple ring, no corner twice, got one from (0, 0) that ",
        ),
        ({"moving": [{"id": 1}]}, "$.moving[0]: must have the field radius, got id"),
        (
            {"moving": [{"id": 1, "radius": 0.2, "track": [[0, 2, 0], [1, 2, 1], [1, 2, 0]]}]},
            "$.moving[0].track[2]: must be later than t = 1 s, got t = 1 s",
        ),
        (
            {"moving": [{"id": 1, "radius": 0.2, "track": [[0, -1.7, 0], [9, 2, 1]]}]},
            "$.start, place of robot 1: must be > robot_radius_m = 0.12 m away from $.moving[0] at t = 0 s",
        ),
        ({"goal": [0.0, 0.0]}, "$.goal: must be >= 0 m away from $.circles[0] (the circle at (0, 0)), got"),
        ({"goal": [0.0, -1.82]}, "$.goal: must be >= 0 m away from $.walls[0] (the polygon from (-4, -2)), "),
        ({"bounds": [4.0, -2.0, -4.0, 2.0]}, "$.bounds[0]: must be < x_m_max = -4 m, got 4"),
        (
            {"start": [-99.0, 0.0, 0.0]},
            "$.start, place of robot 1: must be inside the bounds by the radius,"
            " at x >= x_m_min + 0.12 = -3.88 m, got (-99, 0)",
        ),
        ({"units": "cm"}, "$.units: must be 'm', got 'cm'"),
        ({"circles": None, "circle": []}, "$: must have the field circles, got schema, "),
        ({"polygons": None, "polygon": []}, "$: must have the field polygons, got schema, "),
    ],
)
def test_an_invalid_scene_is_refused_in_one_line(tmp_path: Path, changes: dict[str, Any], line: str) -> None:
    with pytest.raises(UsageError) as refusal:
        _load(tmp_path, changes)
    assert str(refusal.value).startswith(f"{tmp_path / 'posts.json'}: {line}")
    assert "\n" not in str(refusal.value)
    assert "use fewer robots" not in str(refusal.value), "that would not help"
