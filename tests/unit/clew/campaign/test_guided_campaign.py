from pathlib import Path
from typing import Any

import pytest
from click.testing import Result

from tests.support.breaking import break_at_restarts
from tests.support.campaigns import clew, told

SEED = "19"  # its own faults start nobody again, and its strikes do


def swarm(out: Path, *more: str, seeds: str = SEED, jobs: str = "1") -> Result:
    return clew("campaign", "--faults", "swarm", "--seeds", seeds, "--jobs", jobs, "--out", out, *more)


def without_times(outcomes: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{**each, "wall_s": 0.0, "cpu_s": 0.0} for each in outcomes]


@pytest.mark.long
def test_a_guided_campaign_says_how_often_it_struck_and_is_the_same_on_several_processes(
    tmp_path: Path,
) -> None:
    result = swarm(tmp_path / "one", "--guided", seeds="19-22")
    assert result.exit_code == 0
    assert told(tmp_path / "one")["guided"]
    episodes = told(tmp_path / "one")["episodes"]
    strikes = sum(len(each["branches"].split(",")) for each in episodes if each["branches"])
    assert strikes > 4
    assert f"guided: {strikes} strikes" in result.output
    assert swarm(tmp_path / "two", "--guided", seeds="19-22", jobs="2").exit_code == 0
    assert without_times(told(tmp_path / "two")["episodes"]) == without_times(episodes)


def test_a_surprising_chain_is_written_and_played_alone_it_is_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    break_at_restarts(monkeypatch)
    assert swarm(tmp_path / "guided", "--guided").exit_code == 1
    (found,) = told(tmp_path / "guided")["surprises"]
    assert "@" in found["replay"]
    assert len(list((tmp_path / "guided" / "drawn").iterdir())) == 2
    assert swarm(tmp_path / "alone", "--future", found["branches"]).exit_code == 1
    (alone,) = told(tmp_path / "alone")["surprises"]
    of_the_place = {"key": "", "replay": ""}
    (alone,), (found,) = (without_times([each | of_the_place]) for each in (alone, found))
    assert alone == found


@pytest.mark.parametrize(
    "options",
    [
        ("--guided", "--future", "3.101:r1:1"),
        ("--future", "tomorrow"),
    ],
)
def test_options_that_make_no_sense_are_refused(tmp_path: Path, options: tuple[str, ...]) -> None:
    assert swarm(tmp_path, *options).exit_code == 2


def test_only_a_swarm_is_guided() -> None:
    result = clew("campaign", "--scenes", "anywhere", "--guided")
    assert result.exit_code == 2
    assert "--faults swarm" in result.output
