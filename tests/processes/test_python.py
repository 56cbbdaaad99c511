"""Clew in Python with real processes, in this tree and installed elsewhere."""

import os
import re
import shlex
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

import clew
from clew.fleet.live import processes_of
from protocol.root import ROOT
from tests.support.deadline import DEADLINE_S
from tests.support.docs import example
from tests.support.installed import install
from tests.support.processes.plugin import played


def test_a_live_fleet_is_waited_for_broken_and_read(tmp_path: Path) -> None:
    with clew.launch("grove", robots=4, seed=3, speed="max", out=tmp_path / "run") as fleet:
        fleet.leader.freeze(at="after_plan", step=2, for_s=0.5, name="planned")
        planned = fleet.until("step.planned", step=2)
        assert (fleet.run.verdict, fleet.run.entries("step.planned", step=2)[0]) == (None, planned)
        with fleet.partition([1, 2], [3]) as cut:
            fleet.until("view.proposed")
        fleet.leader.kill()
        succeeded = fleet.until("leader.succeeded")
        run = fleet.finish()
    assert run.verdict is not None
    assert (run.verdict.violations, run.flaws) == (0, ())
    assert {each.rule for each in run.faults if each.process} == {"planned", "given-2.r1"}
    cuts = [each.t_s for each in run.faults if each.rule == cut.name]
    assert cuts
    assert max(cuts) <= succeeded.t_s  # the partition had healed
    assert {each.fate for each in run.messages} >= {"delivered", "dropped"}
    assert [rule.fault for rule in fleet.plan.rules] == ["freeze", "partition", "kill"]


def test_a_live_fleet_that_is_left_early_is_stopped_and_leaves_nothing(tmp_path: Path) -> None:
    with clew.launch("grove", robots=2, speed=2.0, out=tmp_path / "run") as fleet:
        fleet.until("step.planned", step=1)
        with pytest.raises(clew.WaitFailedError, match=r"router.lost did not come: .* have passed \(.*load"):
            fleet.until("router.lost", timeout_s=0.5)
    run = clew.open(tmp_path / "run")
    assert run.verdict is not None
    assert run.verdict.reason == "the run was told to end"
    assert processes_of(tmp_path) == {}


def test_a_live_fleet_that_cannot_start_says_why(tmp_path: Path) -> None:
    (tmp_path / "something").touch()
    with (
        clew.launch("grove", robots=2, out=tmp_path) as fleet,
        pytest.raises(clew.WaitFailedError, match=r"did not start: .*is not empty"),
    ):
        fleet.begin()


def test_a_failing_live_test_is_shrunk_by_rehearsals_or_says_that_it_passes_there(tmp_path: Path) -> None:
    test = """
@pytest.mark.clew(robots=2)
def test_all_arrive(clew_fleet):
    fleet = clew_fleet
    fleet.link(1, 2).drop(0.1)
    fleet.tail.kill(step=2)
    run = fleet.finish()
    assert run.verdict.robots_arrived == 2

def test_is_never_live(clew_fleet):
    clew_fleet.link(1, 2).drop(0.1)
    clew_fleet.until("step.planned")
    assert not hasattr(clew_fleet, "speed")
"""
    code, said = played(tmp_path, test)
    assert code == 1, said
    assert "faults: 1 of 2 that were given matter, rehearsed:" in said
    assert 'name = "kill-2"' in said
    assert "the test does not fail in the same way when it is rehearsed" in said


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Python of a fresh environment, in which this checkout is installed by pip.

    What we need of others is taken from our own environment, but for pip, which uv leaves out of that.
    """
    folder = tmp_path_factory.mktemp("elsewhere")
    subprocess.run([sys.executable, "-m", "venv", folder / "env"], timeout=DEADLINE_S, check=True)
    python = folder / "env" / "bin" / "python"
    [packages] = (folder / "env").glob("lib/python*/site-packages")
    (packages / "ours.pth").write_text(f"{sysconfig.get_path('purelib')}\n", encoding="utf-8")
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "--quiet"]
    command: list[str | Path] = [python, "-m", "pip", "install", *options, str(ROOT)]
    subprocess.run(command, cwd=folder, env=bare(), timeout=DEADLINE_S, check=True)
    return python


def bare() -> dict[str, str]:
    """The environment without any trace of this tree and of this session of pytest."""
    ours = ("PYTHON", "PYTEST", "CLEW", "COV")
    return {name: value for name, value in os.environ.items() if not name.startswith(ours)}


def there(python: Path, *arguments: str) -> str:
    """What a command says in a folder outside of the checkout; checks that it succeeds."""
    said = subprocess.run(
        [python, *arguments],
        cwd=python.parents[2],
        env=bare(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=3 * DEADLINE_S,
        check=False,
    )
    assert said.returncode == 0, said.stdout + said.stderr
    return said.stdout


def test_an_installed_package_has_all_its_files_and_its_command(elsewhere: Path) -> None:
    at = there(
        elsewhere, "-c", "import clew, protocol.root as root; print(clew.__file__, root.LAUNCH)"
    ).split()
    assert all(Path(path).is_relative_to(elsewhere.parents[1]) for path in at)
    clew_ = [str(elsewhere.with_name("clew"))]
    said = there(elsewhere, *clew_, "rehearse", "grove", "-n", "2", "--faults", "tail-killed", "--out", "run")
    assert "OK: every living robot has arrived" in said
    assert there(elsewhere, *clew_, "report", "run") == "run/report.html\n"


def test_the_line_that_installs_an_extra_works_for_an_installed_package(elsewhere: Path) -> None:
    line = there(
        elsewhere, "-c", "from clew.verbs.extras import install_line; print(install_line('plot'))"
    ).strip()
    assert line == f"{elsewhere} -m pip install 'clew[plot]'"
    said = there(elsewhere, *shlex.split(line)[1:], "--no-index", "--dry-run")
    assert re.search(r"already satisfied: matplotlib.* \(from clew\[plot\]\)", said), said


def test_an_installed_package_runs_live_fleets_under_drawn_faults(elsewhere: Path) -> None:
    clew_ = str(elsewhere.with_name("clew"))
    said = there(elsewhere, clew_, "chaos", "--runs", "1", "--seed", "4", "--speed", "5", "--out", "ch")
    assert "OK: " in said


@pytest.mark.parametrize(
    "options",
    [
        pytest.param(["--clew-stage=rehearsal"], id="rehearsal"),
        pytest.param(["-k", "frozen"], id="live", marks=pytest.mark.long),
        pytest.param(["-n", "2"], id="each on its own, in parallel", marks=pytest.mark.long),
        pytest.param(["--clew-stage=live", "-k", "partition"], id="live as asked", marks=pytest.mark.long),
    ],
)
def test_the_three_tests_of_the_page_pass_elsewhere_on_both_stages(
    elsewhere: Path, options: list[str]
) -> None:
    (elsewhere.parents[2] / "test_fleet.py").write_text(example("testing.md", "python"), encoding="utf-8")
    said = there(elsewhere, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_fleet.py", *options)
    assert f"{1 if '-k' in options else 5} passed" in said


def test_an_installed_law_leads_a_live_fleet_elsewhere(elsewhere: Path) -> None:
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--disable-pip-version-check", "--quiet"]
    there(elsewhere, "-m", "pip", "install", *options, str(ROOT / "docs" / "examples" / "roomy"))
    said = there(elsewhere, "-m", "clew.cli", "run", "grove", "-n", "2", "--law", "roomy", "--speed", "max")
    assert "OK: every living robot has arrived" in said


def test_a_law_of_a_file_leads_a_live_fleet_whose_robots_start_again(tmp_path: Path) -> None:
    law = f"{ROOT / 'docs' / 'examples' / 'roomy' / 'roomy.py'}:roomy"
    with clew.launch("grove", robots=3, law=law, speed="max", out=tmp_path / "run") as fleet:
        fleet.leader.restart(at="after_plan", step=2, after_s=0.5)
        run = fleet.finish()
    assert run.verdict is not None
    assert (run.ok, run.verdict.robots_arrived) == (True, 3), run.verdict.reason
    assert (tmp_path / "run" / "roomy.py").exists()
    assert run.replay().ok


def test_a_robot_without_the_law_refuses_the_mission_and_the_run_ends_with_that_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install(tmp_path / "packages", "far", {"far": "far:law"})
    (tmp_path / "packages" / "far.py").write_text(
        "import sys\n\n\ndef law(seen): return None\n\n\n"
        "if 'agents.process.host' in sys.modules: raise ImportError('not on this robot')\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "packages"))
    monkeypatch.syspath_prepend(tmp_path / "packages")
    with clew.launch("grove", robots=2, law="far", out=tmp_path / "run") as fleet:
        run = fleet.finish()
    assert run.verdict is not None
    assert (run.verdict.exit_code, run.verdict.robots_arrived) == (1, 0)
    why = "the law 'far' cannot be loaded from far:law: ImportError: not on this robot"
    refusal = f"it refuses the mission: {why}"
    assert refusal in run.verdict.reason
    assert [entry.reason for entry in run.entries("robot.failed")] == [refusal] * 2
