"""`clew judge` prints what true poses show, and exits as other verbs do."""

import json
import re
import socket
from pathlib import Path

import pytest

from protocol.faults.manual_faults import WHERE_FILE
from tests.support.campaigns import clew
from tests.support.judges import poses, scenario, written
from world.scenario.reading import SCENARIOS

POST = {"shape": "circle", "centre_m": [4.0, 0.4], "radius_m": 0.2}
SCENE = {
    "schema": "clew-scene/1",
    "robot_radius": 0.1,
    "goal": [4.0, 0.0],
    "goal_tol": 0.1,
    "bounds": [0.0, -9.0, 9.0, 9.0],
    "circles": [[4.0, 0.32, 0.2]],
    "polygons": [],
}


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run without a verdict in which one robot has arrived."""
    folder = tmp_path / "run"
    folder.mkdir()
    lines = written(poses(1, (0.0, 3.0, 0.0), (2.0, 4.0, 0.0)), scenario(obstacle=[POST]))
    (folder / "events.jsonl").write_bytes(b"".join(lines))
    return folder


def test_it_prints_least_distances_places_and_the_judgement(run: Path) -> None:
    said = clew("judge", run)
    assert said.exit_code == 0
    assert said.stdout.splitlines() == [
        "least clearance: robot 1 and obstacle 1: 0.1000 m at t=2.00 s",
        "least moving clearance: none",
        "least separation: none",
        "robot 1 stands at (4.0000, 0.0000), 1 in the chain",
        "nearest to the goal: 0.0000 m",
        "OK: promises kept, arrived; there is no verdict",
    ]
    assert clew("judge", run / "events.jsonl").stdout == said.stdout


def test_of_a_run_that_is_still_going_on_it_says_so(
    tmp_path: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # the name of a socket has to be short
    with socket.socket(socket.AF_UNIX) as world:
        world.bind("w.sock")
        world.listen()
        (run / WHERE_FILE).write_text("w.sock")
        said = clew("judge", run)
    assert said.stderr == f"{run}: the run is still going on: this is what was recorded up to now\n"
    assert said.stdout.endswith("; there is no verdict\n")
    assert clew("judge", run).stderr == "", "its world cannot be reached any more"


def test_another_scene_is_judged_instead_of_that_in_the_header(tmp_path: Path, run: Path) -> None:
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(SCENE))
    said = clew("judge", run, path)
    assert said.exit_code == 1
    assert "S1 (clearance): robot 1 and obstacle 1: 0.0200 m at t=2.00 s, required 0.0450 m" in said.stdout
    assert said.stdout.endswith("FAILED: promises broken, arrived; there is no verdict\n")
    differs = "other obstacles, bounds, goal, distances to keep"
    assert said.stderr == f"{path}: is not the scenario of this run: {differs}; the judgement is by {path}\n"


def test_the_scenario_of_the_run_itself_is_no_other_one(tmp_path: Path) -> None:
    run = tmp_path / "run"
    clew("rehearse", "door", "-n", "1", "--out", run)
    for scene in ("door", run / "scenario.toml"):
        said = clew("judge", run, scene)
        assert (said.exit_code, said.stderr, said.stdout) == (0, "", clew("judge", run).stdout)
    assert "other obstacles, bounds, goal; " in clew("judge", run, "grove").stderr


def test_a_scene_may_be_a_scenarios_name(run: Path) -> None:
    said, again = clew("judge", run, "grove"), clew("judge", run, SCENARIOS / "grove.toml")
    assert "is not the scenario of this run" in said.stderr
    assert said.stdout == again.stdout


def test_json_has_the_same(run: Path) -> None:
    said = json.loads(clew("judge", run, "--json").stdout)
    assert said["ok"]
    assert said["clearance"]["distance_m"] == pytest.approx(0.1)
    assert (said["places_m"], said["chain"], said["disagreements"]) == ({"1": [4.0, 0.0]}, [1], None)


@pytest.mark.parametrize("name", ["run/verdict.json", "run/none.jsonl", "none"])
def test_what_is_no_run_is_refused_in_one_line(tmp_path: Path, run: Path, name: str) -> None:
    (run / "verdict.json").write_text("{")
    for arguments in (("judge", tmp_path / name), ("judge", run)):
        said = clew(*arguments)
        assert said.exit_code == 2
        assert said.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "is neither a scene nor a scenario with one fleet"),
        ("fleet = 'x'", "is neither a scene nor a scenario with one fleet"),
        ("[[fleet]]\nname = 'x'", "is neither a scene nor a scenario with one fleet"),
        ("[fleet]\n[law]\nepsilon_m = nan", "has a number that is not finite"),
        ("[fleet]\n[goal]\nat_m = [inf, 0.0]", "has a number that is not finite"),
    ],
)
def test_a_scene_that_says_nothing_or_no_numbers_proves_nothing(
    tmp_path: Path, run: Path, text: str, why: str
) -> None:
    (tmp_path / "scene.toml").write_text(text)
    said = clew("judge", run, tmp_path / "scene.toml")
    assert (said.exit_code, said.stderr) == (2, f"Error: {tmp_path}/scene.toml: {why}\n")


@pytest.mark.parametrize("number", ["NaN", "Infinity", "-1e999", "1e300", '"3"', "[]"])
@pytest.mark.parametrize("field", ["t_s", "x_m"])
def test_a_pose_that_is_nowhere_is_refused_and_no_proof(run: Path, field: str, number: str) -> None:
    """No comparison with NaN says that a pose is too near."""
    header, *entries = (run / "events.jsonl").read_text().splitlines()
    wrong = re.sub(rf'"{field}": ?[^,}}]+', f'"{field}":{number}', entries[-1])
    (run / "events.jsonl").write_text("\n".join([header, *entries[:-1], wrong, ""]))
    said = clew("judge", run)
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert said.stderr.startswith(f"Error: {run}: ")


def test_a_header_with_a_number_that_is_not_finite_is_refused(run: Path) -> None:
    text = (run / "events.jsonl").read_text()
    (run / "events.jsonl").write_text(re.sub('"epsilon_m": ?[^,}]+', '"epsilon_m":NaN', text))
    refusal = f"Error: {run}: the header has a number that is not finite\n"
    assert (clew("judge", run).exit_code, clew("judge", run).stderr) == (2, refusal)


@pytest.mark.parametrize("text", ["{}\n", '{"kind":"pose.sampled"}\n', "[1]\n", "3\n"])
def test_a_log_without_a_header_is_refused_in_plain_words(run: Path, text: str) -> None:
    (run / "events.jsonl").write_text(text)
    said = clew("judge", run)
    assert (said.exit_code, said.stderr) == (2, f"Error: {run}: the first line is no header of a run\n")


def test_an_empty_log_is_called_so(run: Path) -> None:
    (run / "events.jsonl").write_text("")
    assert clew("judge", run).stderr == f"Error: {run}: it is empty: no header of a run\n"


def test_a_verdict_that_lacks_a_field_is_refused_in_one_line(run: Path) -> None:
    (run / "verdict.json").write_text("{}")
    said = clew("judge", run)
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)


@pytest.fixture
def fleets(tmp_path: Path) -> Path:
    """A run with two fleets of one robot, without verdicts; both have arrived, 0.1 m apart on the way."""
    for name, y_m in (("east", 0.0), ("west", 0.3)):
        (folder := tmp_path / name).mkdir()
        lines = written(poses(1, (0.0, 3.0, y_m), (2.0, 4.0, 0.0)), scenario())
        (folder / "events.jsonl").write_bytes(b"".join(lines))
    return tmp_path


def test_fleets_of_one_run_are_judged_each_and_against_each_other(fleets: Path) -> None:
    said = clew("judge", fleets)
    assert said.exit_code == 1
    last = said.stdout.splitlines()[-3:]
    assert last[0].startswith("nearest between fleets: robot 1 of east and robot 1 of west: -0.2000 m")
    assert last[1].startswith("contact: robot 1 of east and robot 1 of west")
    assert last[2] == "FAILED: 2 fleets, 1 contacts between them"
    assert said.stdout.splitlines()[0] == "fleet east:"


def test_a_verdict_on_fleets_that_says_something_better_is_refuted(fleets: Path) -> None:
    verdict = {"ok": True, "between_m_min": 0.1, "contact_count": 0, "fleets": {"east": {}, "south": {}}}
    (fleets / "verdict.json").write_text(json.dumps(verdict))
    wrong = json.loads(clew("judge", fleets, "--json").stdout)["disagreements"]
    assert [each.split(",")[0].split(" is ")[0] for each in wrong] == [
        "between_m_min",
        "contact_count",
        "fleets are east",
        "ok",
    ]


def test_a_verdict_on_fleets_that_forgives_one_of_them_is_refuted(fleets: Path) -> None:
    short = written(poses(1, (0.0, 3.0, 5.0)), scenario())
    (fleets / "west" / "events.jsonl").write_bytes(b"".join(short))
    verdict = {"ok": True, "between_m_min": 4.8, "contact_count": 0, "fleets": {"east": {}, "west": {}}}
    (fleets / "verdict.json").write_text(json.dumps(verdict))
    wrong = json.loads(clew("judge", fleets, "--json").stdout)["disagreements"]
    assert wrong == ["ok, by true poses not west"]


def test_a_scene_is_for_one_fleet(fleets: Path) -> None:
    refused = clew("judge", fleets, "grove.toml")
    assert refused.exit_code == 2
    assert "judge the folder of one fleet with it" in refused.stderr
