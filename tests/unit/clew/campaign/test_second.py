"""A campaign has the second judge look at some episodes; a disagreement is a surprise."""

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import Result

from clew.campaign import second
from protocol.timeline import PromiseBroken
from tests.support.campaigns import clew, scene
from world.judge.monitor import Least, Monitor
from world.judge.moves import Intervals


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    scene(tmp_path / "scenes" / "one.json")
    return tmp_path


def campaign(folder: Path, *more: str) -> Result:
    names = ("--scenes", folder / "scenes", "--out", folder / "out")
    return clew("campaign", *names, "--robots", "2", "--jobs", "1", *more)


def outcomes(folder: Path) -> list[dict[str, Any]]:
    lines = (folder / "out" / "episodes.jsonl").read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines]


def test_the_first_of_every_so_many_episodes_is_judged_twice(folder: Path) -> None:
    assert campaign(folder, "--seeds", "1-5", "--judge-every", "2").exit_code == 0
    assert [each["judged"] for each in outcomes(folder)] == [True, False, True, False, True]
    assert campaign(folder, "--seeds", "1-5", "--judge-every", "0").exit_code == 0
    assert len(outcomes(folder)) == 5, "what was judged counts where nothing has to be"


def test_what_was_not_judged_twice_is_played_again_where_it_has_to_be(folder: Path) -> None:
    campaign(folder, "--seeds", "1-2")
    campaign(folder, "--seeds", "1-2", "--judge-every", "1")
    assert [(each["seed"], each["judged"]) for each in outcomes(folder)] == [(1, True), (2, False), (2, True)]


def test_a_disagreement_is_a_surprise(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    watch = Monitor.watch_all

    def lenient(self: Monitor, intervals: Intervals) -> list[tuple[float, PromiseBroken]]:
        broken = list(watch(self, intervals))
        self.least_clearance = Least(distance_m=1.0)
        return broken

    monkeypatch.setattr(Monitor, "watch_all", lenient)
    said = campaign(folder)
    assert said.exit_code == 1
    assert "judges: scenes/one, seed 1: clearance_m_min is" in said.stdout


def test_a_second_judge_that_fails_is_a_surprise_and_the_campaign_goes_on(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise ZeroDivisionError("no way")

    monkeypatch.setattr(second, "judge", fail)
    said = campaign(folder, "--seeds", "1-2")
    assert "judges: scenes/one, seed 1: the second judge fails: ZeroDivisionError: no way" in said.stdout
    assert "FAILED: no promise broken in 2 runs; 2 arrived; surprises: 1. Campaign: " in said.stdout
