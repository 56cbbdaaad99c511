"""The second judge reads poses and scenes as they are documented, and believes no robot."""

import json
import tomllib
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from clew.judge.poses import judge
from clew.judge.truth import UnreadableError, read
from protocol.root import ROOT
from tests.support.judges import poses, scenario, written

KILLED = {"kind": "fault.injected", "fault": "kill", "rule": "kill-1", "process": "r2", "t_s": 1.0}
PLAN = {"name": "p", "rule": [{"name": "kill-1", "fault": "kill"}]}
RESTARTS = {"name": "p", "rule": [{"name": "kill-1", "fault": "restart"}]}
DROPS = {"name": "p", "rule": [{"name": "kill-1", "fault": "drop"}]}


def test_poses_count_in_the_order_of_time_and_only_from_the_world() -> None:
    lines = written(
        [*poses(1, (1.0, 2.0, 0.0), (0.0, 1.0, 0.0)), *poses(1, (0.5, 9.0, 9.0), source="r1")], scenario()
    )
    assert np.array_equal(read(lines).robots[1].track, [(0.0, 1.0, 0.0), (1.0, 2.0, 0.0)])


@pytest.mark.parametrize(
    ("source", "faults", "harmed"),
    [
        ("world", None, {2}),
        ("r2", PLAN, {2}),
        ("r2", RESTARTS, {2}),
        ("r2", None, set()),
        ("r2", {"rule": []}, set()),
        ("r2", DROPS, set()),
        ("r1", PLAN, set()),
    ],
)
def test_a_robot_is_harmed_by_the_word_of_the_world_or_of_the_plan(
    source: str, faults: object, harmed: set[int]
) -> None:
    entries = [*poses(2, (0.0, 1.0, 0.0)), {**KILLED, "source": source}]
    assert read(written(entries, scenario(), faults)).harmed == harmed


@pytest.mark.parametrize("fault", ["start", "thaw", "slow", "drop"])
def test_other_faults_harm_nobody(fault: str) -> None:
    entries = [*poses(2, (0.0, 1.0, 0.0)), {**KILLED, "source": "world", "fault": fault}]
    assert not read(written(entries, scenario())).harmed


def test_only_the_last_line_may_be_torn() -> None:
    lines = written(poses(1, (0.0, 1.0, 0.0)), scenario())
    torn = b'{"kind":"pose.sampled","sour'
    assert len(read(BytesIO(b"".join([*lines, torn]))).robots[1].track) == 1
    for damaged in (torn, torn + b'":' + b"[" * 99_999 + b"\n"):
        with pytest.raises(UnreadableError, match="line 3 cannot be read"):
            read(BytesIO(b"".join([*lines, damaged, *lines[1:]])))


@pytest.mark.parametrize("lines", [[], [b"{}\n"], [b"[]\n"], [b"not a run\n"], [b"\xff\n"], [b"{}"]])
def test_what_is_no_run_is_refused(lines: list[bytes]) -> None:
    with pytest.raises(UnreadableError):
        read(lines)


def test_a_scene_in_json_means_the_same_as_its_scenario() -> None:
    text = (
        '{"schema": "clew-scene/1", "robot_radius": 0.2, "goal": [3, 4], "goal_tol": 0.3,'
        ' "bounds": [0, 1, 2, 3], "circles": [[1, 2, 0.5]], "polygons": [[[0, 0], [1, 0], [0, 1]]],'
        ' "walls": [[[5, 5], [6, 5], [5, 6]]], "moving": [{"id": 7, "radius": 0.4, "track": [[0, 1, 2]]}]}'
    )
    truth = read(written(poses(1, (0.0, 1.0, 0.0)), scenario()), json.loads(text))
    assert [each.name for each in truth.obstacles] == ["obstacle 1", "obstacle 2", "obstacle 3"]
    assert [each.radius_m for each in (*truth.obstacles, *truth.movers)] == [0.5, 0.0, 0.0, 0.4]
    assert truth.movers[0].name == "moving obstacle 7"
    assert (truth.goal_m, truth.bounds, truth.robots[1].hull_m) == ((3, 4), (0, 1, 2, 3), 0.2)
    lengths_m = (truth.clearance_m, truth.separation_m, truth.goal_m_max, truth.behind_m_max)
    assert lengths_m == pytest.approx((0.045, 0.045, 0.305, 0.465))


@pytest.mark.parametrize(
    ("fast", "room_m"),
    [
        ({}, 0.1),
        ({"obstacle_speed_mps_max": 1.0}, 0.1),
        ({"obstacle_speed_mps_max": 1.5}, 0.11),
        (
            {"moving": [{"id": "a", "shape": "circle", "radius_m": 0.1, "track": [[0, 0, 0], [2, 0, 4]]}]},
            0.14,
        ),
        ({"obstacle_speed_mps_max": 1.0, "law": {"law": "printed", "epsilon_m": 0.1, "mu0_m": 0.02}}, 0.05),
    ],
)
def test_where_obstacles_are_fast_robots_may_stand_further_behind_each_other(
    fast: dict[str, object], room_m: float
) -> None:
    truth = read(written([], scenario(**fast)))
    assert truth.behind_m_max == pytest.approx(0.2 + room_m + 0.06)


@pytest.mark.parametrize("law", ["printed", "resultant"])
def test_laws_that_promise_nothing_ask_for_no_contact_only(law: str) -> None:
    lines = written([], scenario(law={"law": law, "epsilon_m": 0.1, "mu0_m": 0.02}))
    truth = read(lines, scenario(law={"law": "certified", "epsilon_m": 0.1, "mu0_m": 0.02}))
    assert (truth.clearance_m, truth.separation_m) == (0.0, 0.0)


def test_every_other_law_promises_clearance_also_a_users() -> None:
    truth = read(written([], scenario(law={"law": "mine", "epsilon_m": 0.1, "mu0_m": 0.02})))
    assert truth.clearance_m == pytest.approx(0.08)


@pytest.mark.parametrize("path", sorted((ROOT / "launch" / "scenarios").glob("*.toml")), ids=lambda p: p.stem)
def test_each_scenario_of_ours_is_read(path: Path) -> None:
    raw = tomllib.loads(path.read_text())
    lines = written(poses(1, (0.0, 0.0, 0.0)), {**raw, "law": {"law": "certified", **raw["law"]}})
    assert judge(read(lines, raw)).places_m == {1: (0.0, 0.0)}


@pytest.mark.parametrize("scene", [[], {"fleet": {}}, {"schema": "clew-scene/1"}])
def test_a_scene_that_lacks_something_is_refused(scene: Any) -> None:  # noqa: ANN401 - anything may be in a file
    with pytest.raises(UnreadableError):
        read(written([], scenario()), scene)
