"""Laws of users, rehearsed: they keep the clearance whatever they propose, and the run can be repeated."""

import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

import clew
from clew.api.launched import LaunchedFleet
from clew.log.journals import stop
from protocol import law_files, laws
from protocol.root import ROOT
from tests.support.campaigns import clew as verb
from tests.support.installed import install
from tests.support.judges import differences, found_in
from tests.support.long import long
from world.scenario.reading import SCENARIOS
from world.scenario.scenario import load

ROOMY = ROOT / "docs" / "examples" / "roomy"


@pytest.fixture(autouse=True)
def _only_these(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(laws, "_loaded", {})
    monkeypatch.setattr(laws, "_registered", {})
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def _roomy_is_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    install(tmp_path / "packages", "roomy", {"roomy": "roomy:roomy"})
    monkeypatch.syspath_prepend(tmp_path / "packages")
    monkeypatch.syspath_prepend(ROOMY)
    monkeypatch.delitem(sys.modules, "roomy", raising=False)


def at_the_nearest(seen: clew.Seen) -> clew.Step | None:
    """Drives straight at what is nearest, through it and on."""
    if len(seen.hits) == 0:
        return None
    off = seen.hits - seen.position
    nearest = off[np.argmin(np.hypot(*off.T))]
    return seen.step_to(seen.position + 50.0 * nearest)


def at_random(seen: clew.Seen) -> clew.Step | None:
    """Drives as far as it is let, and farther if it were let, in a direction that is drawn; 12 times."""
    bearings_rad = np.linspace(-3.0, 3.0, 60)
    free = bearings_rad[seen.free_m(bearings_rad) > 0.1]
    if seen.steps == 12 or len(free) == 0:
        return None
    return clew.Step(np.random.default_rng(seen.seed).choice(free), 1e6)


def stumbles(seen: clew.Seen) -> clew.Step:
    """Raises for one scan in two; drives on as well as it can for the others."""
    if seen.seed % 2:
        raise KeyError("typo")
    free_m = seen.free_m(seen.bearings_rad)
    ends = seen.position + free_m[:, None] * np.column_stack(
        [np.cos(seen.bearings_rad), np.sin(seen.bearings_rad)]
    )
    best = int(np.argmin(seen.cost_to_go_m(ends)))
    return clew.Step(seen.bearings_rad[best], free_m[best])


def test_a_law_that_raises_is_told_of_where_it_is_asked_again(tmp_path: Path) -> None:
    """Where obstacles move, a leader asks again. The run may fail for want of time, and not say why."""
    clew.register_law("mine", stumbles)
    run = clew.rehearse("pedestrian", law="mine", time_s_max=10.0, out=tmp_path / "run")
    assert run.entries("route.lost") == []
    failures = run.entries("law.failed")
    assert failures
    assert all("the law mine failed: KeyError: 'typo' (test_laws.py:" in each.reason for each in failures)
    assert differences(tmp_path / "run") == []


@pytest.mark.parametrize(
    ("law", "scenario", "seed", "reason", "steps"),
    [
        (at_the_nearest, "grove", 1, "no_route: the leader lost its route", 1),
        *long(
            [
                (at_random, "grove", 1, "no_route: the leader lost its route", 8),
                (at_random, "paper", 1, "every living robot has arrived", 10),  # without a goal
            ]
        ),
    ],
)
def test_a_law_that_drives_at_obstacles_keeps_the_clearance(
    law: clew.Law, scenario: str, seed: int, *, reason: str, steps: int, tmp_path: Path
) -> None:
    clew.register_law("mine", law)
    run = clew.rehearse(scenario, robots=3, seed=seed, law="mine", out=tmp_path / "run")
    assert run.verdict is not None
    assert (run.verdict.law, run.verdict.violations) == ("mine", 0)
    assert run.verdict.reason.startswith(reason)
    assert len(run.steps) >= steps
    found = found_in(tmp_path / "run")
    assert [*found.broken, *differences(tmp_path / "run")] == []
    assert found.clearance is not None
    assert found.clearance.distance_m < 0.13, "it comes as near as it may"
    assert (run.check().ok, run.replay().ok) == (True, True)


@pytest.mark.usefixtures("_roomy_is_installed")
def test_the_law_of_the_example_arrives_and_the_same_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    faults = [clew.kill("leader", at="after_plan", step=2), clew.restart("world", after_s=0.5, from_s=6.0)]
    for name in ("one", "other"):
        run = clew.rehearse("grove", robots=3, law="roomy", faults=faults, out=tmp_path / name)
        assert run.ok
        assert {entry.law for entry in run.entries("step.planned") if not entry.joins} == {"roomy"}
    assert run.verdict is not None
    assert run.verdict.robots_arrived == 2
    assert run.check().ok
    assert run.replay().ok
    assert differences(tmp_path / "one") == []
    texts = [(tmp_path / name / "events.jsonl").read_bytes() for name in ("one", "other")]
    assert texts[0] == texts[1]


def test_the_example_is_a_small_package_with_the_entry_point_that_the_page_shows() -> None:
    code = (ROOMY / "roomy.py").read_text(encoding="utf-8").splitlines()
    assert len(code) <= 40
    entry = '[project.entry-points."clew.laws"]\nroomy = "roomy:roomy"\n'
    assert entry in (ROOMY / "pyproject.toml").read_text(encoding="utf-8")
    assert entry in (ROOT / "docs" / "laws.md").read_text(encoding="utf-8")


def test_a_log_under_a_law_that_is_not_here_can_be_read_but_not_replayed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    clew.register_law("mine", lambda _: None)
    clew.rehearse("grove", robots=1, law="mine", out=tmp_path / "run")
    monkeypatch.setattr(laws, "_registered", {})
    run = clew.open(tmp_path / "run")
    assert run.check().ok
    assert verb("log", "check", run.folder).exit_code == 0
    assert run.scenario.law.law == "mine"
    with pytest.raises(clew.UsageError, match=r"^the law must be one of certified, .*, got 'mine'"):
        run.replay()
    with pytest.raises(clew.UsageError, match=r"scenario.toml: \$\.law\.law: must be one of certified"):
        clew.rehearse(str(tmp_path / "run" / "scenario.toml"))


LAW_FILE = """
import clew

def onward(seen: clew.Seen) -> clew.Step:
    if seen.steps == 3:
        raise ValueError("three steps are enough")
    return seen.step_to(seen.goal)
"""


@pytest.fixture
def _has_law_file(tmp_path: Path) -> None:
    (tmp_path / "laws").mkdir()
    (tmp_path / "laws" / "mylaw.py").write_text(LAW_FILE)


@pytest.mark.usefixtures("_has_law_file")
def test_a_run_under_a_law_of_a_file_has_the_file_and_is_played_again_from_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = clew.rehearse("grove", robots=2, law="laws/mylaw.py:onward", out=tmp_path / "run")
    law = run.scenario.law.law
    assert law.startswith("mylaw.py:onward@")
    assert {entry.law for entry in run.entries("step.planned")} == {law}
    shutil.move(tmp_path / "run", tmp_path / "moved")
    shutil.rmtree(tmp_path / "laws")
    assert (tmp_path / "moved" / "mylaw.py").read_text() == LAW_FILE
    monkeypatch.setattr(law_files, "_folders", {})
    monkeypatch.setattr(laws, "_loaded", {})
    assert clew.open(tmp_path / "moved").replay().ok
    again = clew.rehearse(str(tmp_path / "moved" / "scenario.toml"), out=tmp_path / "again")
    texts = [(tmp_path / name / "events.jsonl").read_bytes() for name in ("moved", "again")]
    assert texts[0] == texts[1]
    assert again.replay().ok


@pytest.mark.usefixtures("_has_law_file")
def test_a_law_that_a_scenario_names_is_looked_for_beside_it_and_one_that_is_asked_for_where_we_are(
    tmp_path: Path,
) -> None:
    scenario = (SCENARIOS / "grove.toml").read_text().replace('"certified"', '"mylaw.py:onward"')
    path = tmp_path / "laws" / "own.toml"
    path.write_text(scenario)
    assert load(str(path)).law.law.startswith("mylaw.py:onward@")
    with pytest.raises(clew.UsageError, match=r"\$\.law\.law: mylaw\.py: cannot be read: No such file"):
        load(str(path), law="mylaw.py:onward")
    path.write_text(scenario.replace("mylaw.py:", "mylaw."))
    with pytest.raises(clew.UsageError, match=r"own\.toml: \$\.law\.law: must be a name, or FILE\.py:NAME"):
        load(str(path))


@pytest.mark.usefixtures("_has_law_file")
def test_a_run_whose_law_was_changed_since_is_read_but_not_replayed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = clew.rehearse("grove", robots=2, law="laws/mylaw.py:onward", out=tmp_path / "run")
    (tmp_path / "run" / "mylaw.py").write_text("")
    monkeypatch.setattr(law_files, "_folders", {})
    monkeypatch.setattr(laws, "_loaded", {})
    assert run.check().ok
    assert verb("log", "check", run.folder).exit_code == 0
    seen = verb("log", "why", run.folder, "r1:6")
    assert (seen.exit_code, seen.stderr.count("\n")) == (2, 1)
    assert "its file is not here, or was changed" in seen.stderr
    for refused in (run.replay, lambda: stop.moments(run.folder, until_s=1.0, robot=1)):
        with pytest.raises(clew.UsageError, match="its file is not here, or was changed"):
            refused()
    with pytest.raises(clew.UsageError, match="the file was changed; its law is"):
        clew.rehearse(str(tmp_path / "run" / "scenario.toml"))


def test_real_robots_need_a_law_that_is_installed() -> None:
    clew.register_law("mine", lambda _: None)
    with pytest.raises(clew.UsageError, match="'mine' is registered in this process alone; robots are"):
        clew.launch("grove", law="mine")
    assert isinstance(clew.launch("grove", law="printed"), LaunchedFleet)
