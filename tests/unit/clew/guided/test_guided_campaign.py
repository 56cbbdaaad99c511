from pathlib import Path

import pytest
from click.testing import Result

from tests.support.breaking import break_at_restarts
from tests.support.campaigns import clew, told

SEED = "19"  # its own faults start nobody again


def swarm(out: Path, *more: str) -> Result:
    return clew("campaign", "--faults", "swarm", "--seeds", SEED, "--jobs", "1", "--out", out, *more)


@pytest.mark.long
def test_a_guided_campaign_says_how_many_futures_and_cells_it_has_reached(tmp_path: Path) -> None:
    result = swarm(tmp_path, "--guided")
    assert result.exit_code == 0
    assert told(tmp_path)["guided"]
    (episode,) = told(tmp_path)["episodes"]
    assert f"guided: {episode['futures']} futures, {episode['cells']} cells" in result.output
    assert episode["futures"] > 0


def test_a_surprising_future_is_written_and_played_alone_it_is_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    break_at_restarts(monkeypatch)
    assert swarm(tmp_path / "guided", "--guided").exit_code == 1
    (found,) = told(tmp_path / "guided")["surprises"]
    assert "@" in found["replay"]
    assert len(list((tmp_path / "guided" / "drawn").iterdir())) == 2
    assert swarm(tmp_path / "alone", "--future", found["branches"]).exit_code == 1
    (alone,) = told(tmp_path / "alone")["surprises"]
    same = ("branches", "surprise", "reason", "sim_s", "path_m")
    assert [alone[name] for name in same] == [found[name] for name in same]


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
