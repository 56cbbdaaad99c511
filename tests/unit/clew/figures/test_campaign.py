"""Figures of a campaign: they draw the counted shares and name unreadable episodes."""

import json
from pathlib import Path

import msgspec
import numpy as np
import pytest

from clew.campaign.episode import Outcome, Surprise
from clew.campaign.families import ALL
from clew.figures import campaign as of_campaign
from clew.figures.style import Chart, LeftOut
from clew.swarm.classes import FaultClass
from tests.support import campaigns
from tests.support.campaigns import clew
from tests.support.figures import painted
from world.judge.ending import Ending


def outcome(
    seed: int, *, family: str = "barn", surprise: Surprise = Surprise.NONE, **said: object
) -> Outcome:
    of_seed = {"key": str(seed), "seed": seed, "clearance_margin_m": 0.001 * seed, "switching_steps": seed}
    rest = {"robots": 3, "ending": Ending.ARRIVED, "sim_s": 10.0 * seed, "ok": surprise is Surprise.NONE}
    return campaigns.outcome(family=family, surprise=surprise, **{**of_seed, **rest, **said})


def test_a_share_without_failures_has_the_same_bound_as_in_the_campaigns_table() -> None:
    assert of_campaign.lower_limit(1000, 1000) == pytest.approx(1.0 - 3.0 / 1000, abs=1e-5)
    assert of_campaign.lower_limit(0, 10) == 0.0
    assert of_campaign.lower_limit(9, 10) < 0.9


def test_rows_are_families_or_in_a_swarm_classes_and_the_last_row_is_all() -> None:
    scenes = [outcome(1), outcome(2, family="city")]
    assert list(of_campaign.rows_of(scenes)) == ["barn", "city", ALL]
    loss, kill = FaultClass.LOSS.value, FaultClass.KILL.value
    swarm = [outcome(1, classes=(loss,)), outcome(2, classes=(loss, kill)), outcome(3)]
    rows = {name: len(some) for name, some in of_campaign.rows_of(swarm).items()}
    assert rows == {loss: 2, kill: 1, ALL: 3}


def test_the_drawn_shares_are_the_counted_ones() -> None:
    outcomes = [outcome(seed) for seed in range(1, 9)]
    outcomes += [
        outcome(9, surprise=Surprise.VIOLATION),
        outcome(10, surprise=Surprise.UNREACHED, ending="late"),
    ]
    (success,) = (each for each in of_campaign.charts_of(outcomes) if each.name == "success")
    assert isinstance(success, Chart)
    shares = {line.get_label(): np.asarray(line.get_xdata()).tolist() for line in painted(success)[0].lines}
    assert shares == {"no promise broken": [90.0], "no surprise": [80.0], "all that live arrived": [90.0]}


def test_time_against_loss_is_drawn_only_if_messages_were_dropped() -> None:
    kept = of_campaign.charts_of([outcome(1)])
    assert [each.name for each in kept if isinstance(each, LeftOut)] == ["events", "loss"]
    lossy = [outcome(1, injected={"drop": 60}), outcome(2, injected={"drop": 6}, ending="time is up")]
    (loss,) = (each for each in of_campaign.charts_of(lossy) if each.name == "loss")
    assert isinstance(loss, Chart)
    marks = {line.get_label(): np.asarray(line.get_xydata()).tolist() for line in painted(loss)[0].lines}
    assert marks == {"all that live arrived": [[2.0, 10.0]], "they did not": [[0.1, 20.0]]}


def test_an_interrupted_campaign_is_drawn_from_its_episodes(tmp_path: Path) -> None:
    lines = b"\n".join(msgspec.json.encode(outcome(seed)) for seed in (1, 2))
    (tmp_path / "episodes.jsonl").write_bytes(lines + b'\n{"key": "to')
    told = clew("figures", tmp_path, "--format", "svg")
    assert told.exit_code == 0
    assert "there is no campaign.json: drawn from episodes.jsonl" in told.stderr
    assert "barn (2)" in (tmp_path / "figures" / "success.svg").read_text(encoding="utf-8")


def test_an_unreadable_episode_is_named_and_the_others_are_drawn(tmp_path: Path) -> None:
    episodes = [msgspec.to_builtins(outcome(1)), {"key": 3}, msgspec.to_builtins(outcome(2))]
    path = tmp_path / "campaign.json"
    path.write_text(json.dumps({"episodes": episodes}), encoding="utf-8")
    told = clew("figures", path, "--format", "svg")
    assert told.exit_code == 0
    assert "not complete: episode 2 cannot be read" in told.stderr
    assert "barn (2)" in (tmp_path / "figures" / "success.svg").read_text(encoding="utf-8")
