"""Scenario files with several fleets: what each fleet is told, and what is refused."""

import math
from pathlib import Path
from typing import Any

import msgspec
import pytest
from msgspec import ValidationError, convert

from protocol.errors import UsageError
from protocol.files.toml_text import toml_text
from tests.support.stages.fleets import EAST_M, HEAD_ON, LANE_M, WEST_M, fleet, raw, shared
from world.scenario.fleets import SharedGround, has_several, load_fleets
from world.scenario.scenario import load


def written(folder: Path, said: dict[str, Any]) -> str:
    path = folder / "meeting.toml"
    path.write_text(toml_text(said))
    return str(path)


def test_each_fleet_is_told_what_it_would_be_told_alone_and_that_something_moves_as_fast_as_robots() -> None:
    scenarios = shared().scenarios()
    assert list(scenarios) == ["east", "west"]
    for name, here, there in (("east", WEST_M, EAST_M), ("west", EAST_M, WEST_M)):
        mission = scenarios[name].mission()
        assert scenarios[name].fleet.poses()[0].x_m == here
        assert mission.goal is not None
        assert mission.goal.x_m == there
        assert (mission.robots, mission.obstacle_speed_mps_max) == (2, 0.5)
        assert mission.obstacles_move


def test_faster_obstacles_count_and_slower_ones_do_not() -> None:
    assert shared(obstacle_speed_mps_max=0.8).speed_mps_max == 0.8
    assert shared(obstacle_speed_mps_max=0.1).speed_mps_max == 0.5
    runner = {"id": "a", "shape": "circle", "radius_m": 0.2, "track": [[0.0, 3.0, 2.6], [1.0, 3.9, 2.6]]}
    assert shared(moving=[runner]).speed_mps_max == pytest.approx(0.9)


def test_a_file_is_read_back_equal_and_options_apply_to_each_fleet(tmp_path: Path) -> None:
    path = written(tmp_path, raw())
    assert has_several(path)
    assert not has_several("grove")
    loaded = load_fleets(path)
    assert loaded == shared()
    assert convert(msgspec.to_builtins(loaded), SharedGround) == loaded
    changed = load_fleets(path, robots=3, time_s_max=7.0)
    assert [each.robots for each in changed.fleets] == [3, 3]
    assert changed.time.time_s_max == 7.0


def test_what_takes_one_fleet_refuses_several_in_one_line(tmp_path: Path) -> None:
    path = written(tmp_path, raw())
    with pytest.raises(
        UsageError, match="several fleets; only the commands `clew run` and `clew rehearse` take"
    ) as refused:
        load(path)
    assert "\n" not in str(refused.value)


EAST, WEST = HEAD_ON


@pytest.mark.parametrize(
    ("fleets", "more", "said"),
    [
        ((EAST, WEST | {"name": "east"}), {}, r"\$.fleet\[1\].name: must be another"),
        ((EAST, WEST | {"name": "../up"}), {}, "name"),
        ((EAST,), {}, "length >= 2"),
        (
            (EAST, fleet("west", (WEST_M, LANE_M + 0.29, 0.0), (EAST_M, 2.5))),
            {},
            r"robot 1 must start >= 0.3 m from every robot of fleet\[0\], got 0.29 m",
        ),
        ((EAST, WEST | {"goal": {"at_m": (EAST_M, 1.3), "tolerance_m": 0.3}}), {}, "goal: must be >= 0.3 m"),
        ((), {"law": {"law": "printed", "epsilon_m": 0.1, "mu0_m": 0.01}}, "certifies steps"),
    ],
)
def test_fleets_that_cannot_share_ground_are_refused(
    fleets: tuple[dict[str, Any], ...], more: dict[str, Any], said: str
) -> None:
    with pytest.raises(ValidationError, match=said):
        shared(*fleets, **more)


def test_hulls_that_the_sensor_may_miss_are_refused(tmp_path: Path) -> None:
    thin = WEST | {"robot_radius_m": 0.02}
    with pytest.raises(UsageError, match=r"\$.sensor: must be sure of hulls with a radius of 0.02 m"):
        load_fleets(written(tmp_path, raw(EAST, thin)))
    with pytest.raises(UsageError, match="radius of 0 m"):
        load_fleets(written(tmp_path, raw(EAST, WEST | {"robot_radius_m": 0.0})))


def test_a_fleet_that_would_be_refused_alone_is_refused_with_its_name(tmp_path: Path) -> None:
    out = WEST | {"start": (9.0, LANE_M, 0.0)}
    with pytest.raises(UsageError, match=r"inside the bounds.*\(fleet\[1\], west\)"):
        load_fleets(written(tmp_path, raw(EAST, out)))


def test_robots_of_two_fleets_start_so_far_apart_that_each_may_move_beside_what_the_other_hides(
    tmp_path: Path,
) -> None:
    """At 0.24 m and 1 m/s both would stand for ever: nothing permits a motion that somebody may hit."""
    fast = raw()["drive"] | {"speed_mps": 1.0, "speed_mps_max": 2.0}
    narrow = {"epsilon_m": 0.03, "mu0_m": 0.01}
    back_to_back = [
        fleet("west", (3.0, LANE_M, math.pi), (WEST_M, LANE_M), robots=1),
        fleet("east", (3.24, LANE_M, 0.0), (EAST_M, LANE_M), robots=1),
    ]
    line = r"\$.fleet\[0\]: robot 1 must start >= 0.2\d+ m from every robot of fleet\[1\], got 0.24 m: nearer"
    with pytest.raises(UsageError, match=line):
        load_fleets(written(tmp_path, raw(*back_to_back, law=narrow, drive=fast)))
    load_fleets(written(tmp_path, raw(*back_to_back, law=narrow)))  # at 0.5 m/s they may
