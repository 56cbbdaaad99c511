"""A live run with several fleets: what is made before it starts, what is refused, and what starts it."""

from pathlib import Path

import pytest

from clew.fleet.folder import drop_folder
from clew.fleet.parts.command_lines import command_of
from clew.fleet.prepare import Prepared, Shows, prepare
from clew.fleet.stand_in import stand_in
from clew.fleet.supervision.events import HOST, WORLD
from protocol.errors import UsageError
from protocol.faults.process_commands import PIPE
from protocol.files.toml_text import toml_text
from protocol.keys import Keys
from protocol.network.session import read_router_session, read_session
from protocol.run_settings import Settings, read_plan, read_settings
from tests.support.campaigns import clew
from tests.support.stages.fleets import raw
from tests.support.verbs import asked
from world.judge.together import TogetherVerdict
from world.record.run_files import BEGUN_FILE, read_scenario, read_together
from world.scenario.fleets import seed_of


@pytest.fixture
def private(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "meeting.toml").write_text(toml_text(raw()))
    (folder := tmp_path / "private").mkdir()
    return folder


def made(private: Path, *arguments: str) -> Prepared:
    return prepare(asked("meeting.toml", "--out", "run", *arguments), private, terminal=True)


def test_each_fleet_gets_a_folder_a_seed_sessions_and_keys_of_its_own(private: Path) -> None:
    run = made(private, "--seed", "7", "--faults", "loss-50")
    assert (run.fleets, run.robots, run.shows) == (("east", "west"), 4, Shows.LINES)
    assert read_settings(run.folder) == Settings(seed=7, speed=1.0)
    for name in run.fleets:
        assert read_scenario(run.folder / name).name == f"meeting: {name}"
        assert read_settings(run.folder / name) == Settings(seed=seed_of(7, name), speed=1.0)
        assert read_plan(run.folder / name).rules
        session = read_session(private / name / "r2.json")
        assert session.inputs == str(run.folder.absolute() / name / "inputs")
        assert session.keys.root.startswith(f"clew/{name}/")
        assert (private / name / PIPE).readlink() == Path("..", PIPE)
    keys = [read_session(private / name / "world.json").keys for name in run.fleets]
    assert read_router_session(private).fleet_keys == dict.fromkeys(keys, 2)
    assert len({*keys, Keys("clew", keys[0].run)}) == 3


def test_one_world_and_one_host_have_all_fleets(private: Path) -> None:
    run = made(private)
    world, host = command_of(WORLD, run), command_of(HOST, run)
    assert [each for each in world if each.endswith(".json")] == [
        str(private / "east" / "world.json"),
        str(private / "west" / "world.json"),
    ]
    assert host[3:9] == ["--robots", "1-2", "--run", "run/east", "--sessions", str(private / "east")]


@pytest.mark.parametrize("option", [["--view"], ["--deployment", "random"], ["--held", "--speed", "max"]])
def test_what_only_one_fleet_has_is_refused_and_leaves_nothing(private: Path, option: list[str]) -> None:
    with pytest.raises(UsageError, match=f"^{option[0]}: is for a scenario with one fleet$"):
        made(private, *option)
    assert not (private.parent / "run").exists()


@pytest.mark.parametrize("target", ["world", "router"])
def test_a_plan_that_strikes_what_the_fleets_share_is_refused(private: Path, target: str) -> None:
    rule = f'[[rule]]\nfault = "kill"\ntarget = "{target}"\nfrom_s = 1.0\n'
    (private.parent / "plan.toml").write_text(f'name = "plan"\n{rule}')
    with pytest.raises(UsageError, match=rf"rule\[0\].target: several fleets share the {target}"):
        made(private, "--faults", "plan.toml")


def test_a_run_that_never_began_leaves_no_folder_and_no_law(private: Path) -> None:
    (private.parent / "mylaw.py").write_text("def mine(seen): ...")
    run = made(private, "--law", "mylaw.py:mine")
    assert {path.parent.name for path in run.folder.rglob("mylaw.py")} == {"run", "east", "west"}
    drop_folder(run.folder, run.made, run.latest)
    assert not run.folder.exists()


def test_a_run_whose_world_was_killed_gets_a_failed_verdict_on_all(private: Path) -> None:
    run = made(private)
    assert stand_in(run, 137) is None  # it never began
    (private / "west" / BEGUN_FILE).touch()
    verdict = stand_in(run, 137)
    assert isinstance(verdict, TogetherVerdict)
    assert (verdict.ok, verdict.exit_code, verdict.contact_count) == (False, 137, 0)
    assert read_together(run.folder) == verdict


def test_verbs_that_take_one_fleet_name_the_folders_of_all(tmp_path: Path) -> None:
    for name in ("east", "west"):
        (tmp_path / "run" / name).mkdir(parents=True)
        (tmp_path / "run" / name / "events.jsonl").touch()
    run = tmp_path / "run"
    of_one = ["report", "log info", "log cat", "view", "replay", "figures"]
    verbs: list[list[str | Path]] = [[*verb.split(), run] for verb in of_one]
    verbs += [["fault", run, "stop"], ["fault", run, "kill", "1"], ["compare", run, run]]
    for verb in verbs:
        said = clew(*verb)
        assert said.exit_code == 2
        assert f"has several fleets, each with a folder: {run / 'east'}, {run / 'west'}\n" in said.stderr


def test_a_fault_for_a_folder_that_is_no_run_is_refused_as_that(tmp_path: Path) -> None:
    (tmp_path / "campaign.json").touch()
    said = clew("fault", tmp_path, "stop")
    assert (said.exit_code, said.stderr) == (2, f"Error: {tmp_path}: is not the folder of a run\n")


def test_a_folder_of_runs_is_not_taken_for_a_run_with_several_fleets(tmp_path: Path) -> None:
    (tmp_path / "20261122T180626Z-grove-6bea").mkdir()
    (tmp_path / "20261122T180626Z-grove-6bea" / "events.jsonl").touch()
    said = clew("log", "cat", tmp_path)
    assert (said.exit_code, said.stderr.count("\n")) == (2, 1)
    assert f"no run in {tmp_path}: events.jsonl: No such file" in said.stderr
