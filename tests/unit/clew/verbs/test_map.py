"""`clew map`: from a map of ROS to a run, and what is refused."""

import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from clew.maps import scene as made_of_maps
from clew.verbs import map as verb
from protocol.errors import UsageError
from tests.support.campaigns import clew
from tests.support.scenes.maps import written
from world.scenario.scenario import OBSTACLES_MAX, load

ROOM = np.full(
    (8, 24), 254, dtype=np.uint8
)  # 6 m x 2 m at 0.25 m, with a rack, and a column of unknown cells
ROOM[3:5, 12:15] = 0
ROOM[:, -1] = 205
RACK = {(3.0, 0.75), (3.75, 0.75), (3.75, 1.25), (3.0, 1.25)}
ASKED = ("--start", "2.5", "0.5", "0", "--goal", "5", "1.5", "--robot-radius", "0.1")


def corners(printed: str) -> list[set[tuple[float, float]]]:
    """Of each obstacle."""
    return [{(x_m, y_m) for x_m, y_m in ring} for ring in json.loads(printed)["polygons"]]


def test_a_drawn_map_becomes_a_scene_in_which_a_fleet_arrives(tmp_path: Path) -> None:
    made = clew("map", str(written(tmp_path, ROOM, resolution=0.25)), *ASKED)
    assert made.exit_code == 0, made.stderr
    assert made.stderr.endswith("free ground from (0, 0) to (5.75, 2) m\n")
    (tmp_path / "room.json").write_text(made.stdout, encoding="utf-8")
    assert RACK in corners(made.stdout)
    run = clew("rehearse", str(tmp_path / "room.json"), "-n", "2", "--out", str(tmp_path / "run"))
    assert run.exit_code == 0, run.output
    assert "2 of 2 robots arrived" in run.stdout


def test_a_turned_map_is_turned_about_its_lower_left_corner(tmp_path: Path) -> None:
    path = written(tmp_path, ROOM, resolution=0.25, origin=f"[10, -1, {math.pi / 2}]")
    made = clew(
        "map", str(path), "--start", "9.5", "1.5", "1.57", "--goal", "8.5", "4", "--robot-radius", "0.1"
    )
    assert json.loads(made.stdout)["bounds"] == [8.0, -1.0, 10.0, 4.75]
    assert {(10.0 - y_m, x_m - 1.0) for x_m, y_m in RACK} in corners(made.stdout)


def test_coarse_cells_grow_outwards(tmp_path: Path) -> None:
    path = written(tmp_path, ROOM, resolution=0.25)
    made = clew("map", str(path), *ASKED[:5], "4.5", "1", "--coarsen", "4")
    assert json.loads(made.stdout)["bounds"] == [0.0, 0.0, 5.0, 2.0]
    assert all({(3.0, y_m), (4.0, y_m)} <= set().union(*corners(made.stdout)) for y_m in (0.0, 2.0))


def test_unknown_cells_that_free_thresh_frees_are_named(tmp_path: Path) -> None:
    path = written(tmp_path, ROOM, resolution=0.25, free_thresh=0.25)
    assert "8 cells are free by its free_thresh, and have grey 205" in clew("map", str(path), *ASKED).stderr


def test_a_queue_without_room_is_named(tmp_path: Path) -> None:
    made = clew("map", str(written(tmp_path, ROOM, resolution=0.25)), "--start", "0.5", *ASKED[2:])
    assert made.exit_code == 0
    assert "$.start, place of robot 3: must be" in made.stderr
    assert "--deployment random" in made.stderr


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (
            (*ASKED[:1], "3.25", "1", *ASKED[3:]),
            "$.start, place of robot 1: must be >= 0.15 m away from $.polygons[",
        ),
        ((*ASKED[:5], "5", "1.99"), "$.goal: must be"),
        ((*ASKED[:5], "5", "9"), "$.goal: must be inside the bounds"),
        ((*ASKED[:-1], "0"), "$.robot_radius: must be > 0"),
        ((*ASKED[:1], "nan", *ASKED[2:]), "nan is not a finite number"),
        (ASKED[:4], "Missing option '--goal'"),
        (("--start", "-2", "0", "--goal", "5", "-3"), "--start needs 3 numbers, X Y HEADING, got -2 0 ("),
        (("--goal", "5", "1", *ASKED[:3]), "--start needs 3 numbers, X Y HEADING, got 2.5 0.5"),
        ((*ASKED[:3], "90", *ASKED[4:]), "HEADING must be in radians, from -2 pi to 2 pi, got 90"),
        ((*ASKED, "--coarsen", "100"), "no cell is free"),
    ],
)
def test_what_cannot_work_is_refused(tmp_path: Path, asked: tuple[str, ...], said: str) -> None:
    made = clew("map", str(written(tmp_path, ROOM, resolution=0.25)), *asked)
    assert made.exit_code == 2
    assert said in made.stderr
    assert made.stdout == ""


def test_a_refused_place_comes_with_where_the_ground_is(tmp_path: Path) -> None:
    made = clew("map", str(written(tmp_path, ROOM, resolution=0.025)), *ASKED)
    assert made.exit_code == 2
    ground, refused = made.stderr.splitlines()
    assert ground.endswith("free ground from (0, 0) to (0.575, 0.2) m")
    assert "$.start, place of robot 1: must be inside the bounds" in refused


@pytest.mark.parametrize("module", ["PIL", "yaml"])
def test_a_missing_library_is_named_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, module: str
) -> None:
    monkeypatch.setitem(sys.modules, module, None)
    made = clew("map", str(written(tmp_path, ROOM)), *ASKED)
    assert made.exit_code == 2
    assert f"maps need {module}, the extra `maps`: " in made.stderr
    mistyped = clew("map", str(tmp_path / "none.yaml"), *ASKED)
    refusal = f"Error: {tmp_path}/none.yaml: there is no such file\n"
    assert (mistyped.exit_code, mistyped.stderr) == (2, refusal)


def test_a_folder_in_the_place_of_the_file_is_not_called_missing(tmp_path: Path) -> None:
    made = clew("map", str(tmp_path), *ASKED)
    assert (made.exit_code, made.stderr) == (2, f"Error: {tmp_path}: cannot be read: Is a directory\n")


def test_more_obstacles_than_a_scenario_may_have_are_refused_before_they_are_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(made_of_maps, "outlines")
    dots = np.full((220, 220), 254, dtype=np.uint8)
    dots[::2, ::2] = 0
    made = clew("map", str(written(tmp_path, dots)), *ASKED)
    assert made.exit_code == 2
    assert f"must have at most {OBSTACLES_MAX} obstacles, got " in made.stderr
    assert "try --coarsen 2" in made.stderr


def test_a_scene_that_no_verb_would_read_is_not_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(verb, "WRITTEN_BYTES_MAX", 100)
    made = clew("map", str(written(tmp_path, ROOM, resolution=0.25)), *ASKED)
    assert (made.exit_code, made.stdout) == (2, "")
    assert "longer than 100 bytes; try --coarsen 2" in made.stderr


def test_a_verb_that_is_given_a_map_says_how_it_becomes_a_scene() -> None:
    with pytest.raises(UsageError, match=r"`clew map my\.yaml` makes a scene of a map of ROS"):
        load("my.yaml")


def test_an_image_in_place_of_its_yaml_file_is_named_as_that(tmp_path: Path) -> None:
    image = written(tmp_path, ROOM).with_suffix(".pgm")
    assert image.is_file()
    assert f"{image}: is an image; give the YAML file beside it" in clew("map", str(image), *ASKED).stderr
    with pytest.raises(UsageError, match="`clew map` makes a scene of the YAML file of a map of ROS"):
        load(str(image))
