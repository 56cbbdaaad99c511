"""A field is what it was asked to be: the same again, as wide, as dense, and a way through it or none."""

import json
from collections.abc import Iterable
from functools import cache
from hashlib import blake2b
from itertools import chain, combinations, repeat
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
import shapely
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st

from clew.cli import main
from clew.fields.field import BUILDERS, BUILT, Field, scene
from clew.fields.kinds import Kind
from clew.fields.scatter import scatter
from clew.fields.shapes import extent, polygon
from tests.support.scenes.full_map import Answer, Disc, solvable
from tests.support.strategies.examples import examples
from world.geometry.shapes import Polygon
from world.scenario.budget import sure_range_m
from world.scenario.scenario import Scenario, load
from world.scenario.scene import as_scenario

SMALL_M = (4.0, 3.0)
SCATTERED = [kind for kind in Kind if kind not in BUILT]
ROUND = {Kind.RINGS, Kind.SPIRAL}
ROUNDING_M = 1e-9

kinds, seeds = st.sampled_from(Kind), st.integers(0, 3)
few = settings(max_examples=examples(15))


def a_field(kind: Kind, seed: int) -> Field:
    """Small; built ground needs room for some corridors, so its ways are narrow."""
    if kind in BUILDERS:
        return Field(kind=kind, seed=seed, size_m=(4.0, 3.5), spare=0.06)
    return Field(kind=kind, seed=seed, size_m=SMALL_M)


@cache
def small(kind: Kind, seed: int) -> dict[str, Any]:
    return scene(a_field(kind, seed))


def shapes(of: dict[str, Any]) -> list[shapely.Geometry]:
    """The obstacles on the ground; 512 chords to a quarter are off a disc by a millionth of its radius."""
    discs = [shapely.Point(x, y).buffer(radius_m, quad_segs=512) for x, y, radius_m in of["circles"]]
    return discs + polygons(of["polygons"])


def polygons(rings: Iterable[Any]) -> list[shapely.Geometry]:
    return [shapely.Polygon(ring) for ring in rings]


def as_told(asked: dict[str, Any]) -> dict[str, Any]:
    """As a file would hold it."""
    told: dict[str, Any] = json.loads(json.dumps(asked))
    return told


SAID = {
    Kind.CIRCLES: "a90f546150090be6",
    Kind.ELLIPSES: "3981944a748564a9",
    Kind.CONVEX: "fdf2395b4887b127",
    Kind.NONCONVEX: "f17c2ff3f2f5d612",
    Kind.MIXED: "e728767c1207ca86",
    Kind.STARS: "9059ff80d85f194a",
    Kind.CORRIDORS: "11c1895f8772a303",
    Kind.ZIGZAG: "38b79b0d11ef5d8a",
    Kind.COMB: "271e9207858209aa",
    Kind.SPIRAL: "02f1a59aaf4a3c20",
    Kind.RINGS: "0121de1317f102c3",
    Kind.ROOMS: "96ac6a905b21b238",
    Kind.PILLARS: "1145a96b675e33b0",
}
"""What fields of seed 3 say, hashed: a change here changes everybody's worlds."""


@pytest.mark.parametrize("kind", Kind)
def test_the_same_parameters_make_the_same_field_on_any_machine(kind: Kind) -> None:
    said = json.dumps(scene(a_field(kind, 3)))
    assert blake2b(said.encode(), digest_size=8).hexdigest() == SAID[kind]


@pytest.mark.parametrize("kind", Kind)
def test_another_seed_makes_another_field(kind: Kind) -> None:
    one, other = (shapely.union_all(shapes(small(kind, seed))) for seed in (1, 2))
    assert not shapely.equals(one, other)


@given(kinds, seeds)
@few
def test_every_field_loads_as_a_scenario_with_room_for_five_and_the_goal(kind: Kind, seed: int) -> None:
    scenario = msgspec.convert(as_scenario(as_told(small(kind, seed)), "field"), Scenario)
    assert scenario.fleet.robots == 5
    assert sure_range_m(scenario.obstacles, 360) >= 4.0, "one revolution of a common scanner shows it all"


@given(st.sampled_from(SCATTERED), seeds, st.sampled_from([0.02, 0.6]))
@few
def test_obstacles_keep_the_least_width_from_each_other_and_from_the_walls(
    kind: Kind, seed: int, width_m: float
) -> None:
    drawn = scene(Field(kind=kind, seed=seed, size_m=SMALL_M, least_width_m=width_m, density=0.12))
    radii_m = np.array([radius_m for _, _, radius_m in drawn["circles"]] + [0.0] * len(drawn["polygons"]))
    cores = [shapely.Point(x, y) for x, y, _ in drawn["circles"]] + polygons(drawn["polygons"])
    apart_m = shapely.distance(np.array(cores)[:, None], cores) - radii_m[:, None] - radii_m
    np.fill_diagonal(apart_m, np.inf)
    off_walls_m = shapely.distance(np.array(polygons(drawn["walls"]))[:, None], cores) - radii_m
    assert len(cores) >= 2
    assert min(apart_m.min(), off_walls_m.min()) >= width_m - ROUNDING_M


@pytest.mark.parametrize("seed", range(10))
def test_no_obstacle_surrounds_another(seed: int) -> None:
    sides_m = chain([0.1], repeat(1.5))

    def square(_chance: np.random.Generator, _unit_m: float) -> Polygon:
        return polygon(next(sides_m) * np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]))

    chance = np.random.default_rng(seed)
    small, *large = scatter([square], chance, size_m=(2.0, 2.0), density=1.0, least_width_m=0.01, unit_m=1.0)
    outlines = polygons(each.vertices_m for each in large if isinstance(each, Polygon))
    assert not any(outline.intersects(shapely.Point(extent(small)[0])) for outline in outlines)


@given(st.sampled_from(sorted(set(Kind) - ROUND)), seeds)
@few
def test_the_lanes_before_and_behind_the_field_are_free(kind: Kind, seed: int) -> None:
    drawn = small(kind, seed)
    low_x, _, high_x, _ = shapely.union_all(shapes(drawn)).bounds
    start_x, goal_x, spacing_m = drawn["start"][0], drawn["goal"][0], 3.0 * drawn["robot_radius"]
    assert start_x + spacing_m <= low_x + ROUNDING_M
    assert high_x <= goal_x - spacing_m + 1e-3, "one millimetre, to which coordinates are rounded"
    assert drawn["bounds"][0] <= start_x - 4 * spacing_m - drawn["robot_radius"]
    assert drawn["bounds"][2] >= goal_x + 4 * spacing_m + drawn["robot_radius"]


@given(kinds, seeds)
@few
def test_anything_thinner_than_the_least_width_gets_through(kind: Kind, seed: int) -> None:
    drawn = small(kind, seed)
    assert solvable(drawn, Disc(0.99 * a_field(kind, seed).width_m / 2.0)) is Answer.SOLVABLE


@given(st.integers(0, 99), st.floats(0.2, 0.9))
@few
def test_corridors_are_exactly_as_wide_as_asked(seed: int, width_m: float) -> None:
    maze = scene(Field(kind=Kind.CORRIDORS, seed=seed, size_m=SMALL_M, least_width_m=width_m))
    assert maze["stats"]["widest_path_radius"] == width_m / 2.0
    assert solvable(maze, Disc(width_m / 2.0 - 2e-3)) is Answer.SOLVABLE
    assert solvable(maze, Disc(width_m / 2.0 + 2e-3)) is Answer.UNSOLVABLE


@given(st.sampled_from(sorted(BUILDERS)), st.integers(0, 99), st.floats(0.0, 0.3))
@few
def test_built_ways_are_exactly_as_wide_as_asked(kind: Kind, seed: int, spare: float) -> None:
    built = scene(Field(kind=kind, seed=seed, size_m=(4.5, 4.2), spare=spare))
    width_m = 2.0 * (0.15 + 0.05) * (1.0 + spare)
    assert built["stats"]["widest_path_radius"] == pytest.approx(width_m / 2.0)
    assert solvable(built, Disc(width_m / 2.0 - 2e-3)) is Answer.SOLVABLE
    assert solvable(built, Disc(width_m / 2.0 + 2e-3)) is Answer.UNSOLVABLE


@given(st.sampled_from(sorted(ROUND)), st.integers(0, 99))
@few
def test_round_ground_has_its_goal_in_the_middle_and_no_wall_within_its_tolerance(
    kind: Kind, seed: int
) -> None:
    built = small(kind, seed)
    goal = shapely.Point(built["goal"])
    assert shapely.union_all(shapes(built)).convex_hull.buffer(-0.5).covers(goal)
    assert shapely.union_all(shapes(built)).distance(goal) > max(built["goal_tol"], 0.424 / 2.0)


@pytest.mark.parametrize("seed", range(5))
def test_a_comb_has_one_corridor_that_is_no_dead_end(seed: int) -> None:
    comb = small(Kind.COMB, seed)
    walls, height_m = shapely.union_all(shapes(comb)), comb["bounds"][3]
    rows_y_m = np.arange(0.212, height_m, 0.424 + 0.15)
    ways = [shapely.LineString([(-0.1, y_m), (4.1, y_m)]).intersects(walls) for y_m in rows_y_m]
    assert ways.count(False) == 1
    assert len(ways) >= 5
    assert rows_y_m[ways.index(False)] == pytest.approx(comb["goal"][1], abs=2e-3)


@given(st.integers(0, 99))
@few
def test_corridors_form_a_tree_that_reaches_all_ground(seed: int) -> None:
    maze = scene(Field(kind=Kind.CORRIDORS, seed=seed, size_m=SMALL_M))
    ground = shapely.box(*maze["bounds"]).difference(shapely.union_all(shapes(maze)))
    assert isinstance(ground, shapely.Polygon), "one piece"
    assert len(ground.interiors) == 0


@given(st.integers(0, 99))
@few
def test_a_plugged_maze_lets_nothing_through(seed: int) -> None:
    maze = scene(Field(kind=Kind.CORRIDORS, seed=seed, size_m=SMALL_M, plugged=True))
    assert maze["stats"]["widest_path_radius"] == 0.0
    assert solvable(maze, Disc(0.01)) is Answer.UNSOLVABLE


@pytest.mark.parametrize("seed", range(5))
def test_a_maze_has_dead_ends(seed: int) -> None:
    maze = scene(Field(kind=Kind.CORRIDORS, seed=seed))
    walls = shapely.union_all(shapes(maze)).union(
        shapely.union_all([shapely.Polygon(w) for w in maze["walls"]])
    )
    pitch_m, middle_m = 5 * maze["robot_radius"], 2 * maze["robot_radius"]
    columns, rows = Field(kind=Kind.CORRIDORS, seed=seed).cells
    ways = np.zeros((columns, rows), dtype=int)
    for column, row in np.ndindex(columns, rows):
        x_m, y_m = column * pitch_m + pitch_m / 5 + middle_m, row * pitch_m + middle_m
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            way = shapely.LineString([(x_m, y_m), (x_m + dx * pitch_m, y_m + dy * pitch_m)])
            ways[column, row] += not way.intersects(walls)
    assert (ways >= 1).all()
    assert (ways == 1).sum() >= 3


@pytest.mark.parametrize("kind", SCATTERED)
@pytest.mark.parametrize("density", [0.0, 0.1, 0.3])
def test_obstacles_cover_the_share_that_was_asked_for(kind: Kind, density: float) -> None:
    drawn = scene(Field(kind=kind, seed=1, size_m=SMALL_M, density=density, least_width_m=0.0))
    each_m2 = [shape.area for shape in shapes(drawn)]
    ground_m2 = SMALL_M[0] * SMALL_M[1]
    assert sum(each_m2) >= density * ground_m2 - 1e-3
    assert sum(each_m2[:-1]) <= density * ground_m2 or drawn["circles"], "not one more than needed"
    assert drawn["stats"]["density"] == pytest.approx(sum(each_m2) / ground_m2, abs=1e-3)


def test_obstacles_may_overlap_with_a_least_width_of_zero() -> None:
    drawn = scene(Field(kind=Kind.CIRCLES, seed=1, size_m=SMALL_M, density=0.5, least_width_m=0.0))
    assert any(one.intersects(other) for one, other in combinations(shapes(drawn), 2))


@pytest.mark.parametrize(
    ("kind", "convex"), [(Kind.CONVEX, True), (Kind.ELLIPSES, True), (Kind.NONCONVEX, False)]
)
def test_polygons_are_convex_only_for_convex_kinds(kind: Kind, convex: bool) -> None:
    rings = polygons(ring for seed in range(4) for ring in small(kind, seed)["polygons"])
    dents_m2 = [ring.convex_hull.area - ring.area for ring in rings]
    dented = [dent_m2 > 1e-2 * ring.area for dent_m2, ring in zip(dents_m2, rings, strict=True)]
    assert set(dented) == {not convex}


def test_a_mixed_field_holds_discs_and_polygons() -> None:
    drawn = scene(Field(kind=Kind.MIXED, seed=3))
    assert drawn["circles"]
    assert drawn["polygons"]


def clew(*words: str) -> Result:
    return CliRunner().invoke(main, ["field", *words])


def test_the_verb_prints_a_scene_that_other_verbs_load(tmp_path: Path) -> None:
    path = tmp_path / "maze.json"
    path.write_text(clew("corridors", "--seed", "3", "--robot-radius", "0.2").stdout)
    assert as_told(scene(Field(kind=Kind.CORRIDORS, seed=3, robot_radius_m=0.2))) == json.loads(
        path.read_text()
    )
    assert load(str(path)).name == "corridors-3"


def test_the_verb_writes_many_scenes_a_folder_for_each_kind(tmp_path: Path) -> None:
    said = clew("rings", "stars", "--seeds", "2-3", "--spare", "0.06", "--out", str(tmp_path / "narrow"))
    assert said.exit_code == 0, said.stderr
    found = sorted(path.relative_to(tmp_path / "narrow").as_posix() for path in tmp_path.rglob("*.json"))
    assert found == ["rings/rings-2.json", "rings/rings-3.json", "stars/stars-2.json", "stars/stars-3.json"]
    rings = json.loads((tmp_path / "narrow" / found[0]).read_text())
    assert rings == as_told(scene(Field(kind=Kind.RINGS, seed=2, spare=0.06)))


def test_the_verb_replaces_scenes_that_it_has_written_and_no_other_file(tmp_path: Path) -> None:
    kinds = [kind.value for kind in Kind]
    for _ in range(2):
        assert clew(*kinds, "--seed", "2", "--out", str(tmp_path)).exit_code == 0
    mine = tmp_path / "stars" / "stars-2.json"
    written = {path: path.read_bytes() for path in tmp_path.rglob("*.json") if path != mine}
    mine.write_text('{"schema": "clew-scene/1", "name": "stars-2", "polygons": []}')
    said = clew(*kinds, "--seed", "2", "--density", "0.1", "--out", str(tmp_path))
    assert (said.exit_code, said.stderr) == (
        2,
        f"Error: cannot write {mine}: it is there, and bears no mark of Clew, so it would be lost\n",
    )
    assert written == {path: path.read_bytes() for path in tmp_path.rglob("*.json") if path != mine}
    assert mine.read_text().endswith('"polygons": []}')


def test_the_verb_names_the_file_that_is_in_the_place_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "rings").touch()
    said = clew("rings", "--out", str(tmp_path))
    where = tmp_path / "rings"
    assert (said.exit_code, said.stderr) == (2, f"Error: cannot write {where}: {where} is no folder\n")


@pytest.mark.parametrize("words", [("rings", "stars"), ("rings", "--seeds", "1-2")])
def test_several_scenes_are_not_printed(words: tuple[str, ...]) -> None:
    said = clew(*words)
    assert said.exit_code == 2
    assert "for several, give --out" in said.stderr


@pytest.mark.parametrize(
    ("words", "refusal"),
    [
        (["circles", "--density", "-1"], "$.density: must be >= 0.0, got -1.0"),
        (["circles", "--size", "0", "4"], "$.size_m[0]: must be >= 0.01 m, got 0.0"),
        (["circles", "--size", "4", "1e-300"], "$.size_m[1]: must be >= 0.01 m, got 1e-300"),
        (["circles", "--plugged"], "$.plugged: is for corridors only, got circles"),
        (["corridors", "--size", "1", "4"], "$.size_m: must hold 2 x 2 corridors of 0.6 m"),
        (["rings", "--size", "2", "4"], "$.size_m: must be >= 4.5 m, 6 times a way and a wall, for rings"),
        (["rings", "--spare", "0.1", "--least-width", "1"], "$.spare: replaces least_width_m"),
        (["corridors", "--least-width", "0"], "$.least_width_m: must be >= robot_radius_m = 0.15 m"),
        (
            ["circles", "--size", "1000", "1000", "--density", "1"],
            "$.size_m: circles of 1000 x 1000 m have more",
        ),
        (["pillars", "--size", "1000", "1000"], "$.size_m: pillars of 1000 x 1000 m have more than 10000 "),
    ],
)
def test_impossible_parameters_are_refused_in_one_line(words: list[str], refusal: str) -> None:
    said = clew(*words)
    assert said.exit_code == 2
    assert said.stderr.startswith(f"Error: clew field: {refusal}")
    assert said.stderr.count("\n") == 1
