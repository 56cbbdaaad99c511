from pathlib import Path

import pytest

from protocol.errors import UsageError
from world.scenario.reading import SCENARIOS
from world.scenario.scenario import Scenario, load

GROVE = (SCENARIOS / "grove.toml").read_text(encoding="utf-8")
CART = """
[[moving]]
id = "cart"
shape = "circle"
radius_m = 0.1
track = [[0.0, 4.5, 0.5], [2.0, 4.5, 1.5]]
"""
SLED = """
[[moving]]
id = "sled"
shape = "polygon"
vertices_m = [[0.0, 0.0], [0.2, 0.0], [0.2, 0.05]]
track = [[1.0, 3.5, 0.3]]
"""


def _load(tmp_path: Path, text: str) -> Scenario:
    path = tmp_path / "fair.toml"
    path.write_text(text)
    return load(str(path))


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("2.0, 4.5, 1.5", "0.0, 4.5, 1.5", "$.moving[0].track[1]: must be later than t = 0 s, got t = 0 s"),
        ("2.0, 4.5, 1.5", "0.001, 4.5, 1.5", "$.moving[0].track: must be no faster than 100 m/s, got 1000"),
        ('"sled"', '"cart"', "$.moving[1].id: must be another than those before it, got 'cart'"),
        (
            "[0.0, 4.5, 0.5]",
            "[0.0, 1.3, 2.0]",
            "$.fleet.start, place of robot 1: must be > robot_radius_m = 0.1 m away from $.moving[0]"
            " at t = 0 s, got 0.1 m at (1.5, 2)",
        ),
        ("0.1\ntrack", "0.0\ntrack", "$.moving[0].radius_m: must be > 0.0 m, got 0.0"),
        ("[1.0, 3.5, 0.3]", "[-1.0, 3.5, 0.3]", "$.moving[1].track[0][0]: must be >= 0.0, got -1.0"),
        (
            "[0.2, 0.05]]",
            "[0.1, 0.0]]",
            "$.moving[1]: vertices_m must make a simple ring, no corner twice, got one from (0, 0) that",
        ),
    ],
)
def test_invalid_moving_obstacles_are_refused_in_one_line(
    tmp_path: Path, old: str, new: str, line: str
) -> None:
    text = GROVE + CART + SLED
    _load(tmp_path, text)
    assert text.count(old) == 1
    with pytest.raises(UsageError) as refusal:
        _load(tmp_path, text.replace(old, new))
    assert str(refusal.value).startswith(f"{tmp_path / 'fair.toml'}: {line}")


def test_a_track_above_the_scenarios_top_speed_is_refused_with_its_path(tmp_path: Path) -> None:
    rule = r"\$\.moving\[0\]\.track: must be no faster than obstacle_speed_mps_max = 0.4 m/s, got 0.5 m/s"
    with pytest.raises(UsageError, match=rule):
        _load(tmp_path, "obstacle_speed_mps_max = 0.4\n" + GROVE + CART)


def test_robots_get_the_top_speed_of_obstacles_from_the_scenario_or_the_tracks(tmp_path: Path) -> None:
    assert _load(tmp_path, GROVE + SLED).mission().obstacle_speed_mps_max == 0.0
    assert _load(tmp_path, GROVE + CART).mission().obstacle_speed_mps_max == 0.5
    bounded = "obstacle_speed_mps_max = 0.7\n" + GROVE + CART
    assert _load(tmp_path, bounded).mission().obstacle_speed_mps_max == 0.7


def test_the_sensor_must_be_sure_to_see_moving_obstacles_too(tmp_path: Path) -> None:
    still, sled = _load(tmp_path, GROVE), _load(tmp_path, GROVE + SLED)
    assert sled.sharpest_corner_rad < still.sharpest_corner_rad  # its corner is sharper than any of the grove
    thin = _load(tmp_path, GROVE + SLED.replace("[0.2, 0.05]", "[0.2, 0.01]"))
    assert thin.revolutions > still.revolutions
    thinner = _load(tmp_path, GROVE + SLED.replace("[0.2, 0.05]", "[0.2, 0.003]"))
    assert thinner.range_m_used < still.range_m_used == 4.0
