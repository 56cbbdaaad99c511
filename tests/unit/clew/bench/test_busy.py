"""What counts as well beside busy processes."""

import pytest
from msgspec.structs import replace

from clew.bench.busy import BusyRun, busy_run, figures
from tests.support.campaigns import clew
from tests.support.logs.logs import GOOD
from world.judge.recovery import Death
from world.judge.verdict import Verdict

DEATH = Death(
    robot=2, cause_s=1.0, known_s=2.0, ordered=False, detected_s=None, recovered_s=None, returned_s=None
)


def missed(*runs: BusyRun) -> list[str]:
    return [each.name for each in figures(runs) if each.met is False]


@pytest.mark.parametrize(
    ("worse", "name"),
    [
        (replace(GOOD, deaths=(DEATH,)), "declared dead"),
        (replace(GOOD, violations=1), "promises broken"),
        (replace(GOOD, robots_arrived=GOOD.robots - 1), "not arrived"),
    ],
)
def test_one_run_of_many_fails_where_robots_do_not_arrive_or_are_held_for_dead(
    worse: Verdict, name: str
) -> None:
    well = [busy_run(GOOD, "", launcher_s=9.0)] * 4
    assert missed(*well) == []
    assert missed(*well, busy_run(worse, "", launcher_s=9.0)) == [name]


def test_an_unknown_scenario_is_refused_before_the_machine_is_kept_busy(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delattr("clew.verbs.bench_busy.subprocess")
    said = clew("bench", "busy", "groove")
    assert (said.exit_code, said.stdout, said.stderr.count("\n")) == (2, "", 1)
    assert "unknown scenario 'groove'" in said.stderr


def test_a_run_without_a_verdict_fails_and_says_what_the_launcher_said() -> None:
    run = busy_run(None, "the router is not ready", launcher_s=60.0)
    assert (missed(run), run.reason) == (["not arrived"], "the router is not ready")
