"""Campaigns: every episode has an outcome, none is played twice, and surprises are reported by name."""

import contextlib
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from click.testing import Result
from hypothesis import given
from hypothesis import strategies as st

from clew.campaign.episode import Episode, Surprise, surprise_of
from clew.campaign.executors.pool import outcomes_of
from clew.campaign.families import by_family, figures_of
from clew.campaign.scenes import find_scenes, tight_radius_m
from protocol.files.toml_text import toml_text
from protocol.process.asked import EXIT_CODES
from protocol.root import ROOT
from tests.support.campaigns import clew, closed, outcome, refused, scene
from tests.support.deadline import DEADLINE_S
from tests.support.logs.logs import GOOD
from tests.support.long import long
from tests.support.processes.fleets import wait_until
from tests.support.stages.fleets import raw
from world.scenario.scene import EPSILON_M_MAX, EPSILON_RADII


@pytest.fixture
def scenes(tmp_path: Path) -> Path:
    """Two families: one has a scene with a way, the other a scene without."""
    scene(tmp_path / "scenes" / "posts" / "one.json")
    closed(tmp_path / "scenes" / "walls" / "across.json")
    return tmp_path / "scenes"


def campaign(scenes: Path, *more: str | Path) -> Result:
    """Play in this process, with one robot: this is quick."""
    out = scenes.parent / "out"
    return clew("campaign", "--scenes", scenes, "--robots", "1", "--jobs", "1", "--out", out, *more)


def told(scenes: Path) -> dict[str, Any]:
    read: dict[str, Any] = json.loads((scenes.parent / "out" / "campaign.json").read_text(encoding="utf-8"))
    return read


def played(scenes: Path) -> list[str]:
    return (scenes.parent / "out" / "episodes.jsonl").read_text(encoding="utf-8").splitlines()


def test_a_campaign_without_surprises_exits_0_and_prints_a_row_for_each_family(scenes: Path) -> None:
    said = campaign(scenes, "--seeds", "1-2")
    assert said.exit_code == 0, said.stdout
    rows = {line.split("│")[1].strip(): line for line in said.stdout.splitlines() if line.startswith("│")}
    assert list(rows) == ["posts", "walls", "all"]
    families = told(scenes)["families"]
    facts = ("episodes", "arrived", "no_way", "not_asked", "failed", "solvable", "no_route", "surprises")
    assert [families["posts"][fact] for fact in facts] == [2, 2, 0, 0, 0, 2, 0, 0]
    assert [families["walls"][fact] for fact in facts] == [2, 0, 2, 0, 0, 0, 2, 0]
    assert said.stdout.splitlines()[-1].startswith(
        "OK: no promise broken in 4 runs; 2 arrived, 2 found no way. Campaign: "
    )


def test_scenes_are_folders_files_or_names_without_an_option(tmp_path: Path) -> None:
    post = scene(tmp_path / "post.json")
    said = clew("campaign", str(post), "--jobs", "1", "--out", str(tmp_path / "out"))
    assert said.exit_code == 0, said.stderr
    assert [found.path.name for found in find_scenes([Path("door")], None, print)] == ["door.toml"]
    mistyped = clew("campaign", "dor", "--out", str(tmp_path / "none"))
    assert (mistyped.exit_code, mistyped.stderr.count("\n")) == (2, 1)
    assert "did you mean 'door'?" in mistyped.stderr


def test_json_prints_the_campaign_and_nothing_else(scenes: Path) -> None:
    said = campaign(scenes, "--json")
    assert json.loads(said.stdout) == told(scenes)
    (one,) = [each for each in told(scenes)["episodes"] if each["scene"] == "one"]
    assert (one["robots_arrived"], one["goal_reached"], one["solvable"]) == (1, True, True)
    assert one["clearance_margin_m"] == pytest.approx(one["clearance_m_min"] - 0.045)
    assert one["events_per_m"] == pytest.approx(one["planning_events"] / one["path_m"])


def test_the_same_command_again_plays_nothing(scenes: Path) -> None:
    campaign(scenes)
    before = played(scenes)
    assert campaign(scenes).exit_code == 0
    assert played(scenes) == before


def test_only_torn_new_and_changed_episodes_are_played_again(scenes: Path) -> None:
    campaign(scenes)
    path = scenes.parent / "out" / "episodes.jsonl"
    first, second = played(scenes)
    path.write_text(f"{first}\n{second[:40]}", encoding="utf-8")
    scene(scenes / "posts" / "new.json")
    campaign(scenes)
    assert sorted(json.loads(line)["scene"] for line in played(scenes)[2:]) == ["across", "new"]
    scene(scenes / "posts" / "one.json", goal_tol=0.25)
    campaign(scenes)
    assert [json.loads(line)["scene"] for line in played(scenes)[4:]] == ["one"]
    assert told(scenes)["all"]["episodes"] == 3


def test_an_episode_that_raises_is_a_surprise_and_the_campaign_continues(scenes: Path) -> None:
    refused(scenes / "a" / "stuck.json")
    said = campaign(scenes)
    assert said.exit_code == 1
    assert told(scenes)["all"]["episodes"] == 3
    (surprise,) = told(scenes)["surprises"]
    assert (surprise["scene"], surprise["surprise"], surprise["ending"]) == ("stuck", "crashed", "crashed")
    assert "UsageError" in surprise["reason"]
    assert f"./launch/clew rehearse {scenes}/a/stuck.json -n 1 --seed 1" in said.stdout


def test_the_printed_command_line_replays_the_surprise(scenes: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(scenes.parent)
    closed(scenes / "walls" / "lie.json", stats={"widest_path_radius": 0.7})
    assert campaign(scenes).exit_code == 1
    (surprise,) = told(scenes)["surprises"]
    assert surprise["surprise"] == "false_no_route"
    again = clew(*surprise["replay"].split()[1:], "--json")
    assert json.loads(again.stdout)["reason"] == surprise["reason"]
    assert json.loads(again.stdout)["sim_s"] == surprise["sim_s"]


def test_an_episode_out_of_wall_clock_time_is_reported_and_played_again(scenes: Path) -> None:
    assert campaign(scenes, "--wall-s-max", "0.001").exit_code == 1
    (one, _) = told(scenes)["surprises"]
    assert "the wall-clock limit of 0.001 s struck" in one["reason"]
    assert campaign(scenes).exit_code == 0


@pytest.mark.parametrize(
    "wrong",
    [["--seeds", "3-1"], ["--seeds", "x"], ["--tight", "0"], ["--robots", "0"], ["--jobs", "0"]],
)
def test_invalid_options_exit_2(scenes: Path, wrong: list[str]) -> None:
    said = campaign(scenes, *wrong)
    assert (said.exit_code, said.stdout) == (2, "")
    assert not (scenes.parent / "out").exists()


def test_no_scene_exits_2(tmp_path: Path) -> None:
    (tmp_path / "scenes").mkdir()
    assert campaign(tmp_path / "scenes").exit_code == 2
    assert campaign(tmp_path / "nowhere").exit_code == 2
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        ("b.toml", 'name = "b"\n[fleets]\nrobots = 1\n', "did you mean 'fleet'"),
        ("b.toml", 'name = "b\n', "is not TOML"),
        ("b.json", '{"schema": "clew-scene/2"}', "schema"),
        ("b.json", "{", "is not JSON"),
        ("b.toml", toml_text(raw()), "has several fleets"),
    ],
)
def test_a_broken_scene_is_named_with_the_reason_and_the_others_are_played(
    scenes: Path, name: str, text: str, why: str
) -> None:
    broken = scenes / "broken" / name
    broken.parent.mkdir()
    broken.write_text(text, encoding="utf-8")
    said = campaign(scenes)
    assert said.exit_code == 0
    assert f"not played: {broken}: " in said.stderr
    assert why in said.stderr
    alone = clew("campaign", "--scenes", broken.parent)
    assert (alone.exit_code, str(broken) in alone.stderr) == (2, True)


def test_files_that_are_no_scenes_are_not_reported(scenes: Path) -> None:
    for name in ("one.faults.toml", "run.toml", "pyproject.toml"):
        (scenes / name).write_text("[fleets]\n", encoding="utf-8")
    (scenes / "other.toml").write_text("[project]\ntime = 1\n", encoding="utf-8")
    (scenes / "list.json").write_text("[1]", encoding="utf-8")
    assert "not played" not in campaign(scenes).stderr


def test_a_tight_robot_just_fits_and_robots_without_room_behind_it_are_left_out(scenes: Path) -> None:
    said = campaign(scenes / "posts", "--tight", "0.9", "--robots", "2", "--json")
    (one,) = json.loads(said.stdout)["episodes"]
    assert (one["robots"], one["robots_left_out"], one["solvable"]) == (1, 1, True)
    assert json.loads(said.stdout)["all"]["fewer_robots"] == 1
    changed = json.loads((scenes / "out" / "scenes" / "posts" / "one.json").read_text(encoding="utf-8"))
    assert changed["robot_radius"] + EPSILON_M_MAX == pytest.approx(0.9 * 0.7)
    assert "posts/one.json -n 1 --seed 1" in one["replay"]


def test_random_deployment_gives_each_seed_other_starts_and_is_in_the_replay_line(
    scenes: Path,
) -> None:
    said = campaign(scenes / "posts", "--deployment", "random", "--seeds", "1-2", "--json")
    assert said.exit_code == 0
    first, second = json.loads(said.stdout)["episodes"]
    assert first["path_m"] != second["path_m"]
    assert first["replay"].endswith("posts/one.json -n 1 --deployment random --seed 1")
    before = played(scenes / "posts")
    campaign(scenes / "posts", "--seeds", "1-2")
    assert len(played(scenes / "posts")) == len(before) + 2, "other starts make another episode"


def test_the_time_limit_of_all_episodes_is_in_the_replay_line_and_the_reason_says_what_was_tried(
    scenes: Path,
) -> None:
    said = campaign(scenes / "posts", "--time-s-max", "2.5", "--json")
    assert said.exit_code == 1
    (one,) = json.loads(said.stdout)["episodes"]
    assert one["sim_s"] == pytest.approx(2.5, abs=0.1)
    assert re.match(
        r"the time was up with 0 of \d living robots arrived: r1 was driving step 1", one["reason"]
    )
    assert one["replay"].endswith("posts/one.json -n 1 --time-s-max 2.5 --seed 1")


def test_tight_refuses_a_scene_without_its_widest_path(scenes: Path) -> None:
    scene(scenes / "posts" / "one.json", stats={})
    said = campaign(scenes, "--tight", "0.9")
    assert said.exit_code == 2
    assert "widest_path_radius" in said.stderr
    assert not (scenes.parent / "out").exists()


@pytest.mark.parametrize("more", [[], ["--tight", "0.9"]])
def test_a_missing_fault_plan_leaves_no_folder(scenes: Path, more: list[str]) -> None:
    said = campaign(scenes, "--faults", "nope", *more)
    assert said.exit_code == 2
    assert "nope" in said.stderr
    assert not (scenes.parent / "out").exists()


@given(st.floats(0.001, 100.0))
def test_the_tight_radius_plus_its_epsilon_is_the_given_distance(closest_m: float) -> None:
    radius_m = tight_radius_m(closest_m)
    assert 0.0 < radius_m < closest_m
    assert radius_m + min(EPSILON_M_MAX, EPSILON_RADII * radius_m) == pytest.approx(closest_m)


@pytest.mark.parametrize(
    ("violations", "arrived", "no_route", "solvable", "surprise"),
    [
        (0, 5, False, True, Surprise.NONE),
        (0, 5, False, None, Surprise.NONE),
        (0, 2, True, None, Surprise.NONE),
        (0, 0, True, False, Surprise.NONE),
        (1, 5, False, True, Surprise.VIOLATION),
        (1, 0, True, True, Surprise.VIOLATION),
        (0, 4, False, True, Surprise.UNREACHED),
        (0, 0, True, True, Surprise.FALSE_NO_ROUTE),
        (0, 0, False, False, Surprise.MISSED_NO_ROUTE),
        (0, 5, False, False, Surprise.MISSED_NO_ROUTE),
    ],
)
def test_each_combination_of_facts_gives_the_right_surprise(
    violations: int, arrived: int, no_route: bool, solvable: bool | None, surprise: Surprise
) -> None:
    verdict = msgspec.structs.replace(GOOD, violations=violations, robots_arrived=arrived)
    assert surprise_of(verdict, expected=5, no_route=no_route, solvable=solvable) is surprise


def test_family_figures_count_ended_runs_and_rates_use_all_metres_together() -> None:
    outcomes = [
        outcome(switching_steps=2, planning_events=10, path_m=10.0, robots_arrived=5, clearance_margin_m=0.2),
        outcome(switching_steps=6, planning_events=50, path_m=20.0, robots_arrived=4, clearance_margin_m=0.1),
        outcome(ok=False, ending="crashed", surprise=Surprise.CRASHED),
        outcome(ok=False, ending="out of wall-clock time", surprise=Surprise.STOPPED),
        outcome(family="g", switching_steps=100),
    ]
    figures = figures_of(by_family(outcomes)["f"])
    assert (figures.episodes, figures.arrived, figures.surprises, figures.crashed) == (4, 2, 2, 1)
    assert figures.stopped == 1
    assert (figures.switching_steps_median, figures.switching_steps_max) == (2, 6)
    assert (figures.events_per_m, figures.clearance_margin_m_min) == (2.0, 0.1)


@pytest.mark.parametrize("number", [signal.SIGKILL, *long([signal.SIGINT])])
def test_no_outcome_is_lost_when_a_worker_dies_or_gets_an_interrupt(
    scenes: Path, number: signal.Signals
) -> None:
    far = scene(scenes / "far.json", goal=[900.0, 0.0], bounds=[0.0, -1.0, 1000.0, 1.0])
    paths = [scenes / "posts" / "one.json", far]
    episodes = [
        Episode(
            key=str(index),
            path=str(path),
            family="",
            seed=1,
            robots=1,
            robots_left_out=0,
            law=None,
            deployment=None,
            time_s_max=None,
            widest_path_radius_m=None,
            wall_s_max=0.5 if path == far else DEADLINE_S,
        )
        for index, path in enumerate(paths)
    ]
    coming = outcomes_of(episodes, 2)
    first = next(coming)
    for worker in multiprocessing.active_children():
        assert worker.pid is not None
        os.kill(worker.pid, number)
    surprises = {each.key: each.surprise for each in (first, *coming)}
    assert surprises == {"0": Surprise.NONE, "1": Surprise.STOPPED}, "the second does not end"


# A worker notes itself which signals it finds blocked: a look into /proc may come before its exec, or after
# its end. Python runs a `sitecustomize` before all else. What is in `z` never ends, so the campaign lasts.
IN_WORKERS = """
import signal, sys, threading
from pathlib import Path
if any("spawn_main" in each for each in sys.orig_argv):
    blocked = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    with Path(__file__).with_name("noted").open("a") as file:
        file.write(" ".join(str(int(each)) for each in blocked) + "\\n")
    from clew.campaign import episode
    def holding(each, play=episode.play):
        return threading.Event().wait() if "/z/" in each.path else play(each)

    episode.play = holding
"""


@pytest.fixture
def begun(scenes: Path) -> Iterator[subprocess.Popen[str]]:
    """A campaign that was just started on two processes."""
    (scenes.parent / "sitecustomize.py").write_text(IN_WORKERS, encoding="utf-8")
    for index in range(2):  # these are played last
        scene(scenes / "z" / f"{index}.json")
    out = scenes.parent / "out"
    asked = ["--scenes", str(scenes), "--robots", "1", "--out", str(out), "--jobs", "2"]
    process = subprocess.Popen(
        [sys.executable, "-m", "clew.cli", "campaign", *asked],
        env={**os.environ, "PYTHONPATH": f"{scenes.parent}:{ROOT}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    yield process
    with contextlib.suppress(ProcessLookupError):  # as expected: no process of its group is left
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=DEADLINE_S)


@pytest.fixture
def going(scenes: Path, begun: subprocess.Popen[str]) -> subprocess.Popen[str]:
    """The same campaign when it has written its first outcome and has more to play."""
    path = scenes.parent / "out" / "episodes.jsonl"
    wait_until(lambda: True if path.exists() and path.read_bytes().count(b"\n") else None)
    return begun


@pytest.mark.parametrize("number", [signal.SIGINT, *long([signal.SIGTERM])])
def test_workers_start_with_requests_to_end_blocked(
    scenes: Path, begun: subprocess.Popen[str], number: signal.Signals
) -> None:
    noted = scenes.parent / "noted"
    blocked = wait_until(lambda: noted.read_text().splitlines() or None if noted.exists() else None)
    assert all(str(int(number)) in each.split() for each in blocked)
    os.killpg(begun.pid, number)
    _, complaints = begun.communicate(timeout=DEADLINE_S)
    assert begun.returncode == EXIT_CODES[number]
    assert "Traceback" not in complaints


@pytest.mark.parametrize("number", [signal.SIGINT, *long([signal.SIGTERM])])
def test_an_interrupted_campaign_says_so_and_can_be_continued(
    scenes: Path, going: subprocess.Popen[str], number: signal.Signals
) -> None:
    os.killpg(going.pid, number)  # as a terminal does: the workers get it, too
    said, complaints = going.communicate(timeout=DEADLINE_S)
    assert going.returncode == EXIT_CODES[number]
    assert said.splitlines()[-1].startswith("INTERRUPTED: ")
    assert {json.loads(line)["surprise"] for line in played(scenes)} == {"none"}
    assert "Traceback" not in complaints
    finished = played(scenes)
    assert (told(scenes)["interrupted"], told(scenes)["all"]["episodes"]) == (True, len(finished))
    assert 1 <= len(finished) <= 2
    campaign(scenes)
    assert played(scenes)[: len(finished)] == finished
    assert told(scenes)["all"]["episodes"] == len(played(scenes)) == 4


def test_a_campaign_that_is_killed_leaves_no_process(going: subprocess.Popen[str]) -> None:
    going.kill()
    # The workers share its stderr, so end of file comes only when the last of them has ended.
    going.communicate(timeout=DEADLINE_S)
