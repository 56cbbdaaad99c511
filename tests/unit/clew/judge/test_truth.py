"""The second judge reads poses and scenes as they are documented, and believes no robot."""

from pathlib import Path

import numpy as np
import pytest

from clew.judge.poses import judge
from clew.judge.truth import UnreadableError, read_run, read_scene_file, scene_of
from protocol.root import ROOT
from tests.support.judges import poses, scenario, written

KILLED = {"kind": "fault.injected", "fault": "kill", "rule": "kill-1", "process": "r2", "t_s": 1.0}
PLAN = {"name": "p", "rule": [{"name": "kill-1", "fault": "kill"}]}


def test_poses_count_in_the_order_of_time_and_only_from_the_world() -> None:
    lines = written(
        [*poses(1, (1.0, 2.0, 0.0), (0.0, 1.0, 0.0)), *poses(1, (0.5, 9.0, 9.0), source="r1")], scenario()
    )
    assert np.array_equal(read_run(lines).poses[1], [(0.0, 1.0, 0.0), (1.0, 2.0, 0.0)])


@pytest.mark.parametrize(
    ("source", "faults", "harmed"),
    [("world", None, {2}), ("r2", PLAN, {2}), ("r2", None, set()), ("r2", {"rule": []}, set())],
)
def test_a_robot_is_harmed_by_the_word_of_the_world_or_of_the_plan(
    source: str, faults: object, harmed: set[int]
) -> None:
    lines = written([{**KILLED, "source": source}], scenario(), faults)
    assert read_run(lines).harmed == harmed


@pytest.mark.parametrize("fault", ["start", "thaw", "slow", "drop"])
def test_other_faults_harm_nobody(fault: str) -> None:
    assert not read_run(written([{**KILLED, "source": "world", "fault": fault}], scenario())).harmed


def test_only_the_last_line_may_be_torn() -> None:
    lines = written(poses(1, (0.0, 1.0, 0.0)), scenario())
    torn = b'{"kind":"pose.sampled","sour'
    assert len(read_run([*lines, torn]).poses[1]) == 1
    with pytest.raises(UnreadableError, match="line 3 cannot be read"):
        read_run([*lines, torn, *lines[1:]])


@pytest.mark.parametrize("lines", [[], [b"{}\n"], [b"[]\n"], [b"not a run\n"], written([], scenario())[:0]])
def test_what_is_no_run_is_refused(lines: list[bytes]) -> None:
    with pytest.raises(UnreadableError):
        read_run(lines)


def test_a_scene_in_json_means_the_same_as_its_scenario(tmp_path: Path) -> None:
    run = read_run(written(poses(1, (0.0, 1.0, 0.0)), scenario()))
    path = tmp_path / "scene.json"
    path.write_text(
        '{"schema": "clew-scene/1", "robot_radius": 0.2, "goal": [3, 4], "goal_tol": 0.3,'
        ' "bounds": [0, 1, 2, 3], "circles": [[1, 2, 0.5]], "polygons": [[[0, 0], [1, 0], [0, 1]]],'
        ' "walls": [[[5, 5], [6, 5], [5, 6]]], "moving": [{"id": 7, "radius": 0.4, "track": [[0, 1, 2]]}]}'
    )
    scene = scene_of(run, read_scene_file(path))
    assert [each.name for each in scene.obstacles] == ["obstacle 1", "obstacle 2", "obstacle 3"]
    assert scene.movers[0].name == "moving obstacle 7"
    assert (scene.goal_m, scene.bounds) == ((3, 4), (0, 1, 2, 3))
    lengths_m = (scene.radius_m, scene.clearance_m, scene.separation_m, scene.goal_m_max, scene.behind_m_max)
    assert lengths_m == pytest.approx((0.2, 0.045, 0.045, 0.305, 0.465))


@pytest.mark.parametrize("law", ["printed", "resultant"])
def test_laws_that_promise_nothing_ask_for_no_contact_only(law: str) -> None:
    run = read_run(written([], scenario(law={"law": law, "epsilon_m": 0.1, "mu0_m": 0.02})))
    scene = scene_of(run, {"law": {"law": "certified", "epsilon_m": 0.1, "mu0_m": 0.02}})
    assert (scene.clearance_m, scene.separation_m) == (0.0, 0.0)


def test_every_other_law_promises_clearance_also_a_users() -> None:
    run = read_run(written([], scenario(law={"law": "mine", "epsilon_m": 0.1, "mu0_m": 0.02})))
    assert scene_of(run).clearance_m == pytest.approx(0.08)


@pytest.mark.parametrize("path", sorted((ROOT / "launch" / "scenarios").glob("*.toml")), ids=lambda p: p.stem)
def test_each_scenario_of_ours_is_read(path: Path) -> None:
    raw = read_scene_file(path)
    run = read_run(written(poses(1, (0.0, 0.0, 0.0)), {**raw, "law": {"law": "certified", **raw["law"]}}))
    assert judge(scene_of(run, raw), run).places_m == {1: (0.0, 0.0)}


@pytest.mark.parametrize("text", ["[]", "{", '{"fleet": {}}', '{"schema": "clew-scene/1"}'])
def test_a_scene_that_lacks_something_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "scene.json"
    path.write_text(text)
    run = read_run(written([], scenario()))
    with pytest.raises(UnreadableError):
        scene_of(run, read_scene_file(path))
