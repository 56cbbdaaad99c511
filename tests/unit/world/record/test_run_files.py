"""The files that a run begins with: written once, read by all its processes, never changed."""

from itertools import product
from pathlib import Path

import msgspec
import pytest
from msgspec.structs import replace

from protocol.errors import UsageError
from protocol.faults.plan import NO_FAULTS, PLANS, Plan
from protocol.faults.plan import load as load_plan
from protocol.faults.plan_text import FAULTS_FILE
from protocol.run_settings import SCENARIO_FILE, Settings, read_plan, read_settings
from world.record.recorder import Header, RecordingFailedError
from world.record.run_files import check_unchanged, header_of, mark_begun, prepare_folder, read_scenario
from world.scenario.reading import SCENARIOS
from world.scenario.scenario import Scenario, load

ALL_SCENARIOS = sorted(path.stem for path in SCENARIOS.glob("*.toml"))
ALL_PLANS = sorted(path.stem for path in PLANS.glob("*.toml"))
LOSS = load_plan("loss-50")


def began(folder: Path, scenario: Scenario, plan: Plan) -> Header:
    """The header of a run that began in this folder."""
    prepare_folder(folder, scenario, plan, Settings(seed=1))
    header = header_of(
        scenario, plan, run="run", seed=1, speed=None, started_at="2026-11-22T12:00:00+00:00", hlc="0/world"
    )
    return msgspec.json.decode(msgspec.json.encode(header), type=Header)


@pytest.mark.parametrize(("name", "deployment"), [*product(ALL_SCENARIOS, [None]), ("grove", "random")])
def test_a_scenario_is_read_back_equal(tmp_path: Path, name: str, deployment: str | None) -> None:
    scenario = load(name, deployment=deployment, seed=3)
    prepare_folder(tmp_path, scenario, NO_FAULTS, Settings(seed=3))
    assert read_scenario(tmp_path) == scenario
    assert read_scenario(tmp_path).fingerprint() == scenario.fingerprint()


@pytest.mark.parametrize("name", ALL_PLANS)
def test_a_fault_plan_is_read_back_equal(tmp_path: Path, name: str) -> None:
    prepare_folder(tmp_path, load("grove"), load_plan(name), Settings(seed=1))
    assert read_plan(tmp_path) == load_plan(name)


@pytest.mark.parametrize("settings", [Settings(seed=0), Settings(seed=2**53 - 1, speed=0.1)])
def test_settings_are_read_back_equal(tmp_path: Path, settings: Settings) -> None:
    prepare_folder(tmp_path, load("grove"), NO_FAULTS, settings)
    assert read_settings(tmp_path) == settings
    assert read_plan(tmp_path) == NO_FAULTS


def test_a_run_is_resumed_only_with_unchanged_files(tmp_path: Path) -> None:
    grove = load("grove")
    header = began(tmp_path, grove, LOSS)
    check_unchanged(tmp_path, header)
    with pytest.raises(UsageError, match=f"{SCENARIO_FILE}: was changed"):
        check_unchanged(tmp_path, replace(header, scenario_hash="another"))
    (tmp_path / FAULTS_FILE).unlink()
    with pytest.raises(UsageError, match=f"{FAULTS_FILE}: was changed"):
        check_unchanged(tmp_path, header)


def test_a_folder_that_cannot_be_written_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"cannot write into .*: No such file or directory"):
        prepare_folder(tmp_path / "gone", load("grove"), NO_FAULTS, Settings(seed=1))


def test_a_private_folder_that_takes_no_file_ends_the_run_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(RecordingFailedError, match=r"cannot write .*begun: No such file"):
        mark_begun(tmp_path / "full")
