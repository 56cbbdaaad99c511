import json
import re
import sys
from pathlib import Path

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage

from protocol.errors import UsageError
from protocol.files.reading import understand
from protocol.root import ROOT
from tests.support.strategies.shape_strategies import as_shapely
from world.scenario.reading import SCENARIOS
from world.scenario.scenario import Scenario, load, schema

NEARER = "$.law.epsilon_m: must be >= 2 mu0_m + range error = 0.103 m: else obstacles count as robots"
NAMES = sorted(path.stem for path in SCENARIOS.glob("*.toml"))

SOUND = """
name = "sound"
[fleet]
robots = 3
robot_radius_m = 0.1
start = [1.0, 1.0, 0.0]
spacing_m = 0.3
separation_m = 0.05
link_length_m_max = 1.0
[law]
epsilon_m = 0.1
mu0_m = 0.01
[goal]
at_m = [4.0, 1.0]
tolerance_m = 0.1
[bounds]
x_m_min = 0.0
y_m_min = 0.0
x_m_max = 5.0
y_m_max = 2.0
[sensor]
directions = 1440
range_m_max = 4.0
range_sigma_m = 0.001
[drive]
speed_mps = 0.5
speed_mps_min = 0.05
speed_mps_max = 1.0
turn_rate_radps = 1.5
heading_error_rad = 0.0003
[time]
time_s_max = 100.0
[[obstacle]]
shape = "circle"
centre_m = [2.0, 1.0]
radius_m = 0.2
[[obstacle]]
shape = "polygon"
vertices_m = [[3.0, 1.5], [3.5, 1.5], [3.5, 1.9], [3.0, 1.9]]
"""
QUEUE = "start = [1.0, 1.0, 0.0]\nspacing_m = 0.3"


def _load(tmp_path: Path, text: str, **overrides: object) -> Scenario:
    path = tmp_path / "wood.toml"
    path.write_text(text)
    return load(str(path), **overrides)  # type: ignore[arg-type] # tests pass wrong types on purpose


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ("robots = 3", "robots = 0", "$.fleet.robots: must be >= 1, got 0"),
        (
            "robots = 3",
            "robots = 3\ncolour = 1",
            "$.fleet: must have no field but robots, robot_radius_m, separation_m, link_length_m_max, places,"
            " start, spacing_m, deployment, got 'colour' = 1",
        ),
        ("epsilon_m = 0.1", "", "$.law: must have the field epsilon_m, got mu0_m"),
        ("range_m_max = 4.0", "range_m_max = -1.0", "$.sensor.range_m_max: must be > 0.0 m, got -1.0"),
        ("range_m_max = 4.0", "range_m_max = nan", "$.sensor.range_m_max: must be > 0.0 m, got nan"),
        (
            "range_m_max = 4.0",
            "range_m_max = 0.2",
            "$.sensor.range_m_max: must be > fleet.robot_radius_m + law.epsilon_m = 0.2 m, got 0.2",
        ),
        ("range_m_max = 4.0", 'range_m_max = "far"', "$.sensor.range_m_max: must be a number, got 'far'"),
        ("robots = 3", 'robots = "3"', "$.fleet.robots: must be an integer, got '3'"),
        ("start = [1.0, 1.0, 0.0]", "start = [1.0]", "$.fleet.start: must be a list of length 3, got [1.0]"),
        ("start = [1.0, 1.0, 0.0]", "start = 1", "$.fleet.start: must be a list, got 1"),
        (
            "epsilon_m = 0.1",
            'epsilon_m = 0.1\nlaw = "best"',
            "$.law.law: must be one of certified, printed, resultant, got 'best' "
            f"(laws installed for {sys.executable})",
        ),
        (
            "radius_m = 0.2",
            "radius_m = 0.2\ncolour = 1",
            "$.obstacle[0]: must have no field but shape, centre_m, radius_m, got 'colour' = 1",
        ),
        (
            "at_m = [4.0, 1.0]",
            "at_m = [4.0, -99.0]",
            "$.goal.at_m: must be inside the bounds by the radius, "
            "at y >= y_m_min + 0.1 = 0.1 m, got (4, -99)",
        ),
        (
            "at_m = [4.0, 1.0]",
            "at_m = [99.0, 1.0]",
            "$.goal.at_m: must be inside the bounds by the radius, "
            "at x <= x_m_max - 0.1 = 4.9 m, got (99, 1)",
        ),
        (
            "tolerance_m = 0.1",
            'tolerance_m = 0.1\n"a\\nb" = 1',
            "$.goal: must have no field but at_m, tolerance_m, got 'a\\nb' = 1",
        ),
        ("directions = 1440", "directions = 7", "$.sensor.directions: must be >= 8, got 7"),
        ('"circle"', '"ring"', "$.obstacle[0].shape: must be one of circle, ellipse, polygon, got 'ring'"),
        ("radius_m = 0.2", "radius_m = 0.0", "$.obstacle[0].radius_m: must be > 0.0 m, got 0.0"),
        (
            "[3.5, 1.5], [3.5, 1.9]",
            "[3.5, 1.9], [3.5, 1.5]",
            "$.obstacle[1]: vertices_m must make a simple ring, no corner twice,"
            " got one from (3, 1.5) that meets itself",
        ),
        (
            "speed_mps = 0.5",
            "speed_mps = 1.0",
            "$.drive.speed_mps: must be > speed_mps_min = 0.05 and < speed_mps_max = 1 m/s, got 1",
        ),
        ("mu0_m = 0.01", "mu0_m = 0.1", "$.law.mu0_m: must be < epsilon_m = 0.1 m, got 0.1"),
        ("mu0_m = 0.01", "mu0_m = 0.05", f"{NEARER}, got 0.1"),
        (
            "spacing_m = 0.3",
            "spacing_m = 0.24",
            "$.fleet.spacing_m: must be >= 2 robot_radius_m + separation_m = 0.25 m, got 0.24",
        ),
        (
            "spacing_m = 0.3",
            "",
            "$.fleet: must be placed either by places, or by start and spacing_m, or at random, got start",
        ),
        (
            QUEUE,
            "places = [[1.0, 1.0, 0.0], [0.5, 1.0, 0.0]]",
            "$.fleet.robots: must be <= the number of places = 2, got 3",
        ),
        (
            QUEUE,
            "places = [[1.0, 1.0, 0.0], [0.5, 1.0, 0.0], [0.7, 1.0, 0.0]]",
            "$.fleet.places[2]: must be >= 2 robot_radius_m + separation_m = 0.25 m from places[1],"
            " got 0.2 m at (0.7, 1)",
        ),
        (
            "start = [1.0,",
            "start = [1.7,",
            "$.fleet.start, place of robot 1: must be >= 0.2 m away from $.obstacle[0]"
            " (the circle at (2, 1)), got 0.1 m at (1.7, 1)",
        ),
        (
            "start = [1.0,",
            "start = [0.6,",
            "$.fleet.start, place of robot 3: must be inside the bounds by the radius"
            ", at x >= x_m_min + 0.1 = 0.1 m, got (0, 1): use fewer robots (-n), or --deployment random",
        ),
        (
            "at_m = [4.0, 1.0]",
            "at_m = [2.1, 1.0]",
            "$.goal.at_m: must be >= 0.1 m away from $.obstacle[0] (the circle at (2, 1)),"
            " got inside it at (2.1, 1)",
        ),
        ("at_m = [4.0, 1.0]", "at_m = [3.9, 1.7]", None),
        (
            "at_m = [4.0, 1.0]",
            "at_m = [3.52, 1.7]",
            "$.goal.at_m: must be >= 0.1 m away from $.obstacle[1] (the polygon from (3, 1.5)),"
            " got 0.02 m at (3.52, 1.7)",
        ),
        ("x_m_min = 0.0", "x_m_min = 5.0", "$.bounds.x_m_min: must be < x_m_max = 5 m, got 5"),
        (
            'name = "sound"',
            'name = "sound"\ntable_m = [[1.0, 2.0]]\nswitching_positions_max = 2',
            "$.table_m: must be as many rows as switching_positions_max = 2, got 1",
        ),
        (
            'name = "sound"',
            'name = "sound"\ntable_m = [[1.0]]\nswitching_positions_max = 1',
            "$.table_m[0]: must be as many distances as obstacles = 2, got 1",
        ),
        (
            "radius_m = 0.2",
            "radius_m = 0.00005",
            "$.sensor: must be sure of every obstacle out to 2 (fleet.robot_radius_m + law.epsilon_m) ="
            " 0.4 m, got 0.114592 m with 7200 directions",
        ),
        (
            "range_sigma_m = 0.001",
            "range_sigma_m = 0.003",
            "$.law.mu0_m: must be >= 0.0138059 m, which is ray quantisation 1.90386e-06 m"
            " + range noise 0.009 m + drive 0.0048 m + rounding 4e-06 m, got 0.01",
        ),
    ],
)
def test_an_invalid_scenario_is_refused_in_one_line(
    tmp_path: Path, old: str, new: str, line: str | None
) -> None:
    assert SOUND.count(old) == 1
    if line is None:
        _load(tmp_path, SOUND.replace(old, new))
        return
    with pytest.raises(UsageError) as refusal:
        _load(tmp_path, SOUND.replace(old, new))
    assert str(refusal.value) == f"{tmp_path / 'wood.toml'}: {line}"


def test_robots_that_start_too_near_to_each_other_to_move_beside_fast_obstacles_are_refused(
    tmp_path: Path,
) -> None:
    text = (ROOT / "launch" / "scenarios" / "pedestrian.toml").read_text(encoding="utf-8")
    fast = text.replace("[fleet]", "obstacle_speed_mps_max = 2.5\n\n[fleet]", 1)
    with pytest.raises(UsageError, match=r"fleet.spacing_m: must be >= 0.3385 m: .* 2.5 m/s.*got 0.3$"):
        _load(tmp_path, fast)
    assert _load(tmp_path, fast, law="printed").mission().robot_keep_m == pytest.approx(0.26), "no promise"
    assert _load(tmp_path, fast.replace("spacing_m = 0.3", "spacing_m = 0.34")).fleet.spacing_m == 0.34


def test_a_law_without_promises_needs_no_error_budget_and_only_no_contact(tmp_path: Path) -> None:
    near = SOUND.replace("start = [1.0,", "start = [1.65,").replace("directions = 1440", "directions = 360")
    assert _load(tmp_path, near, law="resultant").law.law == "resultant"
    with pytest.raises(UsageError, match=r"robot 1: must be >= 0.1 m away"):
        _load(tmp_path, near.replace("1.65", "1.75"), law="resultant")


def test_a_point_may_not_start_inside_an_obstacle_under_any_law(tmp_path: Path) -> None:
    point = SOUND.replace("robot_radius_m = 0.1", "robot_radius_m = 0.0").replace("[1.0,", "[2.0,")
    with pytest.raises(
        UsageError, match=r"robot 1: must be >= 0 m away from \$\.obstacle\[0\] .*, got inside"
    ):
        _load(tmp_path, point, law="printed")


def test_robots_and_law_can_be_overridden(tmp_path: Path) -> None:
    assert len(_load(tmp_path, SOUND, robots=2).fleet.poses()) == 2
    assert _load(tmp_path, SOUND, law="printed").mission().law == "printed"
    for said in ("3", "'3'"):
        instead = rf"/wood\.toml: \$\.fleet\.robots: must be >= 1, got 0 \(robots = 0 instead of {said}\)$"
        with pytest.raises(UsageError, match=instead):
            _load(tmp_path, SOUND.replace("robots = 3", f"robots = {said}"), robots=0)
    with pytest.raises(
        UsageError,
        match=r"/wood\.toml: \$\.law\.law: must be one of certified, printed, resultant, got 'best'",
    ):
        _load(tmp_path, SOUND, law="best")


def test_a_queue_made_too_long_by_the_n_option_is_refused_with_that_option() -> None:
    with pytest.raises(UsageError) as refusal:
        load("grove", robots=8)
    assert str(refusal.value) == (
        "grove: $.fleet.start, place of robot 6: must be inside the bounds by the radius, at x >= x_m_min"
        " + 0.1 = 0.1 m, got (0, 2): use fewer robots (-n), or --deployment random (robots = 8 instead of 5)"
    )


PATHS = [("fleet", "robots"), ("fleet", "start"), ("law", "law"), ("goal",), ("obstacle",), ("name",)]
VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=6,
)


@given(st.sampled_from(PATHS), VALUES)
def test_every_error_is_one_line_with_path_and_value(path: tuple[str, ...], value: object) -> None:
    raw = msgspec.toml.decode(SOUND)
    inner = raw
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    line = ""
    try:
        understand(raw, Scenario, "wood")
    except UsageError as error:
        line = str(error)
    assert line.isprintable()
    assert re.match(r"$|wood: \$.*: must .*, got ", line)


def test_an_unknown_scenario_is_refused_with_a_list_of_known_ones() -> None:
    known = "door, follower, grove, paper, pedestrian, crossing, dense-eight, head-on, or"
    with pytest.raises(UsageError, match=rf"^unknown scenario 'groove': must be one of {known}"):
        load("groove")


def test_a_file_that_cannot_be_read_or_parsed_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="No such file"):
        load(str(tmp_path / "nowhere.toml"))
    with pytest.raises(UsageError, match=r"/wood\.toml: is not TOML: .*line 3"):
        _load(tmp_path, '\nname = "x"\nrobots =\n')
    path = tmp_path / "wood.json"
    path.write_text("[1, 2")
    with pytest.raises(UsageError, match=r"/wood\.json: is not JSON"):
        load(str(path))


@given(st.binary(max_size=200))
def test_every_invalid_file_raises_a_usage_error(
    tmp_path_factory: pytest.TempPathFactory, text: bytes
) -> None:
    for name in ("any.toml", "any.json"):
        path = tmp_path_factory.getbasetemp() / name
        path.write_bytes(text)
        with pytest.raises(UsageError):
            load(str(path))


def test_the_used_range_is_the_sure_range_of_the_thinnest_obstacle(tmp_path: Path) -> None:
    thin = _load(tmp_path, SOUND.replace("radius_m = 0.2", "radius_m = 0.006"))
    assert thin.mission().range_m_max == pytest.approx(0.012 / (2 * np.pi / 1440))
    assert _load(tmp_path, SOUND).mission().range_m_max == 4.0


def test_robots_queue_behind_the_first_along_its_heading(tmp_path: Path) -> None:
    turned = _load(
        tmp_path, SOUND.replace("start = [1.0, 1.0, 0.0]", "start = [1.0, 1.0, 1.5707963267948966]")
    )
    places = [(pose.x_m, pose.y_m) for pose in turned.fleet.poses()]
    assert np.array(places) == pytest.approx(np.array([(1.0, 1.0), (1.0, 0.7), (1.0, 0.4)]))


@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_survives_the_timelines_header(name: str) -> None:
    scenario = load(name)
    again = msgspec.convert(json.loads(json.dumps(msgspec.to_builtins(scenario))), Scenario)
    assert again == scenario
    assert again.fingerprint() == scenario.fingerprint()
    assert load(name, robots=1).fingerprint() != scenario.fingerprint()


@pytest.mark.parametrize("name", NAMES)
def test_every_scenario_but_the_papers_uses_the_certified_law(name: str) -> None:
    assert load(name).law.law == ("printed" if name == "paper" else "certified")
    assert load(name).name == name
    load(name, law="certified")  # every scenario satisfies its error budget


def test_the_papers_scenario_matches_the_first_row_of_table_1() -> None:
    paper = load("paper")
    assert paper.table_m is not None
    assert len(paper.table_m) == paper.switching_positions_max == 11
    start = shapely.Point(paper.fleet.poses()[0].x_m, paper.fleet.poses()[0].y_m)
    measured = [start.distance(as_shapely(obstacle)) for obstacle in paper.obstacles]
    # The reconstruction's RMS error is 0.025 m over all rows.
    assert measured == pytest.approx(paper.table_m[0], abs=0.05)


def test_the_grove_has_a_way_to_the_goal_with_room_to_spare() -> None:
    grove = load("grove")
    assert {type(obstacle).__name__ for obstacle in grove.obstacles} == {"Circle", "Ellipse", "Polygon"}
    assert grove.goal is not None
    cell_m = 0.04
    x, y = np.meshgrid(np.arange(0.0, 6.0, cell_m), np.arange(0.0, 4.0, cell_m))
    solid = shapely.union_all([as_shapely(obstacle) for obstacle in grove.obstacles])
    rim_m = np.minimum.reduce([x, 6.0 - x, y, 4.0 - y])
    room_m = np.minimum(shapely.distance(solid, shapely.points(x, y)), rim_m)
    regions, _ = ndimage.label(room_m >= grove.closest_m + 0.03)
    first = grove.fleet.poses()[0]
    ends = ((first.x_m, first.y_m), grove.goal.at_m)
    start, goal = (int(regions[round(y_m / cell_m), round(x_m / cell_m)]) for x_m, y_m in ends)
    assert start == goal != 0


UNITS = {"m": "m", "rad": "rad", "mps": "m/s", "radps": "rad/s", "s": "s"}


def test_every_quantity_in_the_schema_has_a_unit() -> None:
    definitions = schema()["$defs"]
    for section in (
        "Fleet",
        "LawSection",
        "Goal",
        "SensorSection",
        "DriveSection",
        "TimeSection",
        "Circle",
        "Ellipse",
        "MovingCircle",
    ):
        for name, described in definitions[section]["properties"].items():
            suffix = re.search(r"_(m|rad|mps|radps|s)(_min|_max)?$", name)
            if suffix is not None:
                said = " ".join(re.findall(r'"description": "([^"]*)"', json.dumps(described)))
                assert re.search(rf"(^|[\[ ]){UNITS[suffix[1]]}($|[\];, ])", said), (section, name, said)
