"""Random deployments: free places on one piece of ground, the same in every kind of run."""

import json
from itertools import combinations
from math import dist
from pathlib import Path

import msgspec
import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.errors import UsageError
from protocol.mission import Bounds
from tests.support.campaigns import clew, scene
from tests.support.docs import example
from tests.support.processes.fleets import Fleet
from tests.support.strategies.examples import examples
from tests.support.strategies.shape_strategies import as_shapely
from world.geometry.clearance import distances
from world.geometry.shapes import Circle, Polygon, Shape, ground_of
from world.scenario.deployment import free_places
from world.scenario.piece import Piece, piece_of
from world.scenario.scenario import Scenario, load

BOUNDS = Bounds(x_m_min=0.0, y_m_min=0.0, x_m_max=4.0, y_m_max=3.0)
INNER = Bounds(x_m_min=0.13, y_m_min=0.13, x_m_max=3.87, y_m_max=2.87)
POST = Circle(centre_m=(2.0, 1.5), radius_m=0.8)
FENCE = Polygon(vertices_m=((1.0, -1.0), (1.2, -1.0), (1.2, 4.0), (1.0, 4.0)))
HULL_M, CLEAR_M = 0.1, 0.2


def piece(*shapes: Shape, at_m: tuple[float, float] | None = None) -> Piece:
    return piece_of(ground_of(shapes), BOUNDS, at_m=at_m, hull_m=HULL_M, clear_m=CLEAR_M)


ROUND_THE_POST = piece(POST)


def drawn(robots: int, seed: int, *, apart_m: float = 0.3) -> list[tuple[float, float]]:
    poses = free_places(
        robots, ROUND_THE_POST, ground_of([POST]), inside=INNER, seed=seed, clear_m=CLEAR_M, apart_m=apart_m
    )
    return [(pose.x_m, pose.y_m) for pose in poses]


@given(st.integers(1, 8), st.integers(0, 2**32))
def test_places_are_free_inside_the_bounds_and_apart(robots: int, seed: int) -> None:
    places = drawn(robots, seed)
    assert len(places) == robots
    assert all(0.13 <= x_m <= 3.87 and 0.13 <= y_m <= 2.87 for x_m, y_m in places)
    assert all(distances(ground_of([POST]), np.array(place)).min() >= CLEAR_M for place in places)
    assert all(dist(one, other) >= 0.3 for one, other in combinations(places, 2))


@given(st.integers(0, 2**32))
def test_a_seed_decides_the_places_and_fewer_robots_start_at_the_first_of_them(seed: int) -> None:
    places = drawn(5, seed)
    assert drawn(3, seed) == places[:3]
    assert drawn(5, seed + 1) != places


def test_without_room_for_all_robots_there_are_fewer_places() -> None:
    assert len(drawn(3, 1, apart_m=5.0)) == 1


@pytest.mark.parametrize(
    ("at_m", "low_m", "high_m"), [((0.5, 1.0), 0.1, 0.8), ((3.0, 1.0), 1.4, 3.9), (None, 1.4, 3.9)]
)
def test_the_chosen_piece_contains_the_given_place_or_is_the_largest(
    at_m: tuple[float, float] | None, low_m: float, high_m: float
) -> None:
    found = piece(FENCE, at_m=at_m)
    held = [float(x_m) for x_m in np.linspace(0.0, 4.0, 401) if found.holds(float(x_m), 1.5)]
    slack_m = 2.0 * found.cell_m  # a cell that is partly occupied does not belong to it
    assert low_m <= held[0] <= low_m + slack_m
    assert high_m - slack_m <= held[-1] <= high_m


@pytest.mark.parametrize(("gap", "crossed"), [(1.9, False), (2.8, True)])
def test_a_gap_wider_than_the_distance_to_keep_joins_two_pieces(gap: float, crossed: bool) -> None:
    half_m = gap * CLEAR_M / 2.0
    below = Polygon(vertices_m=((1.0, -1.0), (1.2, -1.0), (1.2, 1.5 - half_m), (1.0, 1.5 - half_m)))
    above = Polygon(vertices_m=((1.0, 1.5 + half_m), (1.2, 1.5 + half_m), (1.2, 4.0), (1.0, 4.0)))
    assert piece(below, above, at_m=(0.5, 1.5)).holds(3.0, 1.5) is crossed


circles = st.builds(
    Circle,
    centre_m=st.tuples(st.floats(0.0, 4.0), st.floats(0.0, 3.0)),
    radius_m=st.floats(0.05, 0.8),
)


@settings(max_examples=examples(50))
@given(st.lists(circles, max_size=8), st.integers(0, 2**32))
def test_shapely_finds_a_way_between_any_two_places(shapes: list[Circle], seed: int) -> None:
    room = shapely.box(0.0, 0.0, 4.0, 3.0).buffer(-HULL_M)
    free = room.difference(shapely.union_all([as_shapely(each).buffer(CLEAR_M - 1e-3) for each in shapes]))
    ground = ground_of(shapes)
    poses = free_places(4, piece(*shapes), ground, inside=INNER, seed=seed, clear_m=CLEAR_M, apart_m=0.3)
    shared = [
        part for part in shapely.get_parts(free) if part.covers(shapely.Point(poses[0].x_m, poses[0].y_m))
    ]
    assert all(shared[0].covers(shapely.Point(pose.x_m, pose.y_m)) for pose in poses)


# --- scenarios and scenes ---------------------------------------------------------------------------------


def deployed(path: Path, *, robots: int | None = None, seed: int = 1) -> Scenario:
    return load(str(path), robots=robots, deployment="random", seed=seed)


def test_places_drawn_by_the_seed_are_stored_in_the_scenario(tmp_path: Path) -> None:
    path = scene(tmp_path / "posts.json")
    scenario = deployed(path)
    assert (scenario.fleet.deployment, scenario.fleet.start, scenario.fleet.spacing_m) == (
        "random",
        None,
        None,
    )
    assert scenario.fleet.places is not None
    assert len(scenario.fleet.places) == scenario.fleet.robots == 5
    assert deployed(path) == scenario
    assert deployed(path, seed=2).fleet.places != scenario.fleet.places
    assert msgspec.convert(msgspec.to_builtins(scenario), Scenario) == scenario, "places are not drawn again"


def test_a_scenario_file_with_deployment_and_places_draws_nothing(tmp_path: Path) -> None:
    queue = "start = [1.0, 1.0, 0.0]\nspacing_m = 0.3"
    text = example("scenario.md")
    assert queue in text

    def places(said: str, seed: int) -> tuple[tuple[float, float, float], ...] | None:
        (tmp_path / "gate.toml").write_text(text.replace(queue, f'deployment = "random"\n{said}'))
        return load(str(tmp_path / "gate.toml"), seed=seed).fleet.places

    first = places("", 3)
    assert first is not None
    assert places("", 4) != first
    assert places(f"places = {[list(place) for place in first]}", 4) == first
    assert places(queue, 4) is not None, "a queue's start says on which ground"


def test_robots_start_on_the_piece_of_the_scenes_own_start(tmp_path: Path) -> None:
    across = [[2.7, -1.0], [3.2, -1.0], [3.2, 1.0], [2.7, 1.0]]
    path = scene(tmp_path / "closed.json", polygons=[across])
    assert all(pose.x_m < 2.7 for seed in range(5) for pose in deployed(path, seed=seed).fleet.poses())


@pytest.mark.parametrize(
    ("changes", "robots", "line"),
    [
        (
            {},
            2000,
            r"\$\.fleet\.robots: must be <= \d+, for which seed 1 finds .*, got 2000 \(robots = 2000",
        ),
        ({"circles": [[3.0, 0.0, 5.0]]}, None, r"\$\.fleet\.robots: must be <= 0, for which seed 1 finds"),
        ({"bounds": [6.0, -1.0, 0.0, 1.0]}, None, r"\$\.bounds\[0\]: must be < x_m_max = 0 m, got 6"),
        ({"bounds": [0.0, -0.01, 6.0, 0.01]}, None, r"\$\.fleet\.robots: must be <= 0"),
    ],
)
def test_an_impossible_deployment_is_refused_in_one_line(
    tmp_path: Path, changes: dict[str, object], robots: int | None, line: str
) -> None:
    path = scene(tmp_path / "posts.json", **changes)
    with pytest.raises(UsageError, match=rf"posts\.json: {line}") as refused:
        deployed(path, robots=robots)
    assert "deployment = 'random'" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_deployment_without_bounds_is_refused() -> None:
    with pytest.raises(
        UsageError, match=r"paper: \$\.bounds: must be said for a random deployment, got none"
    ):
        load("paper", deployment="random")


def test_places_from_the_command_line_are_in_the_timeline_and_robots_start_there(tmp_path: Path) -> None:
    path = scene(tmp_path / "posts.json")
    said = clew(
        "rehearse", path, "-n", "2", "--deployment", "random", "--seed", "4", "--out", tmp_path / "run"
    )
    assert said.exit_code == 0, said.stderr
    header, *entries = map(json.loads, (tmp_path / "run" / "events.jsonl").read_text().splitlines())
    wanted = deployed(path, robots=2, seed=4)
    assert msgspec.convert(header["scenario"], Scenario) == wanted
    sampled = [each for each in entries if each["kind"] == "pose.sampled" and each["t_s"] == 0.0]
    assert {(each["x_m"], each["y_m"]) for each in sampled} == {
        (pose.x_m, pose.y_m) for pose in wanted.fleet.poses()
    }
    assert clew("log", "check", tmp_path / "run").exit_code == 0


@pytest.mark.processes
def test_a_live_fleet_has_the_same_places_as_a_rehearsed_one(tmp_path: Path) -> None:
    path = scene(tmp_path / "posts.json")
    fleet = Fleet(tmp_path)
    try:
        ended = fleet.run(str(path), "-n", "2", "--deployment", "random", "--seed", "4", "--speed", "max")
        assert ended.code == 0, ended.err
        header = fleet.entries()[0]
    finally:
        fleet.destroy()
    assert msgspec.convert(header["scenario"], Scenario) == deployed(path, robots=2, seed=4)


def test_an_unknown_deployment_exits_with_2(tmp_path: Path) -> None:
    said = clew("rehearse", scene(tmp_path / "posts.json"), "--deployment", "neat")
    assert (said.exit_code, said.stdout) == (2, "")
