import json
import shlex
from pathlib import Path

import pytest

from clew.campaign.failures import Case, failure_of
from clew.campaign.shrink import shrink
from protocol.faults.plan import Plan, load
from protocol.faults.plan_text import plan_text
from protocol.faults.rules import Burst, Corrupt, Delay, Drop, Duplicate, Kill, Partition, Reorder, Rule, Slow
from tests.support.campaigns import clew, scene
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE
from world.scenario.scenario import load as load_scenario

HARMLESS: tuple[Rule, ...] = (
    Delay(delay_s_max=0.05),
    Duplicate(probability=0.2, copies=2, delay_s_max=0.5),
    Corrupt(probability=0.02, bits=3),
    Reorder(hold_s=0.1, probability=0.1),
    Slow(target="r1", delay_s=0.05, for_s=2.0),
    Drop(burst=Burst(enter=0.02, leave=0.5, loss=0.5), kinds=("ahead", "behind")),
)
KILL = Kill(target="r2", from_s=1.0)
PLAN = Plan(name="much", rules=(*HARMLESS[:3], KILL, *HARMLESS[3:]))


@pytest.fixture
def planted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A planted bug that shows only when a strand heals."""

    def heal(**_: object) -> None:
        raise AssertionError("planted")

    monkeypatch.setattr("agents.strand.member.StrandHealed", heal)


def case(tmp_path: Path, plan: Plan) -> Case:
    scenario = load_scenario(str(scene(tmp_path / "small.json")), robots=3)
    return Case(scenario=scenario, seed=1, plan=plan)


def test_without_the_bug_the_run_does_not_fail(tmp_path: Path) -> None:
    assert failure_of(case(tmp_path, PLAN)) is None


@pytest.mark.usefixtures("planted")
def test_a_plan_is_reduced_to_the_one_rule_that_triggers_the_planted_bug(tmp_path: Path) -> None:
    failing = case(tmp_path, PLAN)
    failure = failure_of(failing)
    assert failure is not None
    assert "planted" in failure.reason

    def fails(other: Case) -> bool:
        found = failure_of(other)
        return found is not None and found.way == failure.way

    least = shrink(failing, fails)
    (rule,) = least.plan.rules
    assert isinstance(rule, Kill)
    assert rule.name == "kill-4", "the rule keeps its name, and so its draws"
    assert rule.until_s is not None, "its window is narrower"
    assert least.scenario.fleet.robots == 2, "one robot dies and one calls"
    assert fails(least)


@pytest.mark.usefixtures("planted")
def test_the_printed_line_replays_the_failure_with_the_written_plan(tmp_path: Path) -> None:
    plan = Plan(name="some", rules=(HARMLESS[0], KILL))
    (tmp_path / "some.toml").write_text(plan_text(plan), encoding="utf-8")
    (tmp_path / "mylaw.py").write_text("def mine(seen): return seen.step_to(seen.goal)")
    run, field, law = tmp_path / "run", scene(tmp_path / "small.json"), f"{tmp_path}/mylaw.py:mine"
    clew("rehearse", field, "-n", "3", "--law", law, "--faults", tmp_path / "some.toml", "--out", run)
    (tmp_path / "mylaw.py").unlink()
    shrunk = clew("shrink", run)
    assert shrunk.exit_code == 0, shrunk.output
    line = shlex.split(shrunk.stdout.splitlines()[-1])
    assert line[:2] == ["./launch/clew", "rehearse"]
    assert len(load(line[line.index("--faults") + 1]).rules) == 1
    again = clew(*line[1:], "--out", tmp_path / "again")
    assert "planted" in again.stdout + again.stderr
    assert (tmp_path / "again" / "mylaw.py").exists()


def test_a_run_that_does_not_fail_or_has_no_plan_is_not_shrunk(tmp_path: Path) -> None:
    field = scene(tmp_path / "small.json")
    clew("rehearse", field, "-n", "1", "--out", tmp_path / "none")
    assert clew("shrink", tmp_path / "none").exit_code == 2
    (tmp_path / "mild.toml").write_text(plan_text(Plan(name="mild", rules=HARMLESS[:1])), encoding="utf-8")
    clew("rehearse", field, "-n", "2", "--faults", tmp_path / "mild.toml", "--out", tmp_path / "good")
    assert clew("shrink", tmp_path / "good").exit_code == 1
    assert clew("shrink", tmp_path / "nowhere").exit_code == 2


@pytest.fixture
def failed(tmp_path: Path, planted: None) -> Path:
    """A run that fails by the planted bug; its plan also has a rule that does not matter."""
    assert planted is None
    plan = Plan(name="some", rules=(HARMLESS[0], KILL))
    (tmp_path / "some.toml").write_text(plan_text(plan), encoding="utf-8")
    run, field = tmp_path / "run", scene(tmp_path / "small.json")
    clew("rehearse", field, "-n", "2", "--faults", tmp_path / "some.toml", "--out", run)
    return run


def test_a_run_that_now_fails_in_another_way_is_not_shrunk_and_both_are_reported(
    failed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def heal(**_: object) -> None:
        raise KeyError("another")

    monkeypatch.setattr("agents.strand.member.StrandHealed", heal)
    shrunk = clew("shrink", failed)
    assert (shrunk.exit_code, shrunk.stdout) == (1, "")
    assert "planted" in shrunk.stderr
    assert "rehearsed again it fails in another way: " in shrunk.stderr
    assert "another" in shrunk.stderr
    assert not (failed / "shrunk").exists()


def test_a_seed_is_refused_for_a_run_which_has_one(failed: Path) -> None:
    shrunk = clew("shrink", failed, "--seed", "2")
    assert (shrunk.exit_code, shrunk.stdout) == (2, "")
    assert "is a run; --seed chooses an episode of a campaign" in shrunk.stderr


def test_a_reason_that_is_also_the_way_to_fail_is_printed_once(tmp_path: Path) -> None:
    """All messages are lost, so the world waits for a strand until the time is up."""
    plan = Plan(name="deaf", rules=(Drop(),))
    (tmp_path / "deaf.toml").write_text(plan_text(plan), encoding="utf-8")
    run, field = tmp_path / "run", scene(tmp_path / "small.json")
    asked = ["-n", "2", "--time-s-max", "5", "--faults", str(tmp_path / "deaf.toml"), "--out", str(run)]
    clew("rehearse", field, *asked)
    reason = json.loads((run / VERDICT_FILE).read_text(encoding="utf-8"))["reason"]
    assert clew("shrink", run).stderr.splitlines()[0] == f"shrink: {reason}"


def test_what_is_neither_run_nor_campaign_is_refused_in_a_plain_sentence(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").touch()
    for place in (tmp_path, tmp_path / "notes.txt"):
        said = clew("shrink", place)
        neither = "neither a run (no events.jsonl) nor a campaign (no campaign.json)"
        assert (said.exit_code, said.stderr) == (2, f"Error: {place}: {neither}\n")


def test_a_run_with_several_fleets_is_refused_as_such(tmp_path: Path) -> None:
    for fleet in ("east", "west"):
        (tmp_path / fleet).mkdir()
        (tmp_path / fleet / EVENTS_FILE).touch()
    said = clew("shrink", tmp_path)
    assert said.exit_code == 2
    assert f"{tmp_path}: has several fleets; only a run with one can be shrunk" in said.stderr


def test_a_run_without_a_verdict_is_refused_in_a_plain_sentence(failed: Path) -> None:
    (failed / VERDICT_FILE).unlink()
    for place in (failed, failed / EVENTS_FILE):
        said = clew("shrink", place)
        assert said.exit_code == 2
        assert f"{failed}: has no readable verdict that says how it failed" in said.stderr
    assert "Errno" not in said.stderr


def test_earlier_results_of_shrink_are_kept_and_the_line_names_the_run_and_not_the_latest_one(
    failed: Path,
) -> None:
    (failed / "shrunk").mkdir()
    (failed / "shrunk" / "world.toml").touch()
    (failed.parent / "latest").symlink_to(failed.name)
    said = clew("shrink", failed.parent / "latest")
    assert said.exit_code == 0
    assert f"{failed}/shrunk-2/world.toml" in said.stdout.splitlines()[-1]
    assert sorted(path.name for path in failed.glob("shrunk*")) == ["shrunk", "shrunk-2"]
    again = clew("shrink", failed, "--out", failed / "shrunk")
    assert again.exit_code == 2
    assert "is not empty" in again.stderr


def test_the_plan_of_a_smaller_fleet_does_not_name_the_removed_robots(tmp_path: Path) -> None:
    rules = (
        Drop(sender=("r1", "r3"), receiver=("r3", "r2")),
        Partition(group=("r3",), others=("r1",)),
        Drop(sender=("r2", "r3"), receiver=("r2", "r3")),
    )

    def fails(other: Case) -> bool:
        return _named(other) == ["drop-1", "drop-3"][: max(1, other.scenario.fleet.robots - 1)]

    least = shrink(case(tmp_path, Plan(name="named", rules=rules)), fails)
    (rule,) = least.plan.rules
    assert isinstance(rule, Drop)
    assert (rule.sender, rule.receiver, least.scenario.fleet.robots) == (("r1",), ("r2",), 2)


def _named(case: Case) -> list[str | None]:
    """The Drop rules that are left."""
    return [rule.name for rule in case.plan.rules if isinstance(rule, Drop)]
