"""Two campaigns against each other: what is paired, what counts, and how sure a difference is."""

import json
import math
from collections.abc import Iterable
from pathlib import Path

import msgspec
import numpy as np
import pytest
from scipy.stats import ttest_rel

from clew.campaign.compare import Asked, Compared, Comparison, compare, mean_interval, share_interval
from clew.campaign.episode import Outcome
from protocol.errors import UsageError
from tests.support.campaigns import clew, outcome, scene

LAW = "def mine(seen): return seen.step_to(seen.position + 0.4 * (seen.goal - seen.position))"
Played = tuple[str, int, float, bool]


def played(*episodes: Played) -> list[Outcome]:
    """Outcomes by scene, seed, time, and whether all arrived."""
    return [outcome(scene=name, seed=seed, sim_s=sim_s, ok=ok) for name, seed, sim_s, ok in episodes]


def against(a: Iterable[Outcome], b: Iterable[Outcome]) -> Comparison:
    return compare(a, b, (Asked(), Asked()))


def measured(found: Comparison, measure: str) -> Compared:
    return next(each for each in found.measures if each.measure == measure)


def test_episodes_of_the_same_family_scene_and_seed_are_paired_and_the_others_counted() -> None:
    a = played(("one", 1, 10.0, True), ("one", 2, 10.0, True), ("two", 1, 10.0, True))
    b = played(
        ("two", 1, 12.0, True), ("one", 1, 11.0, True), *(("three", seed, 9.0, True) for seed in (1, 2))
    )
    found = against(a, b)
    assert (found.pairs, found.scenes, found.only_a, found.only_b) == (2, 2, 1, 2)
    assert measured(found, "sim_s").difference == pytest.approx(1.5)


def test_a_fleet_that_gives_up_early_is_not_quick() -> None:
    a = played(("one", 1, 10.0, True), ("two", 1, 10.0, True))
    b = played(("one", 1, 12.0, True), ("two", 1, 1.0, False))
    found = against(a, b)
    times, arrived = measured(found, "sim_s"), measured(found, "arrived")
    assert (times.pairs, times.a, times.b) == (1, 10.0, 12.0)
    assert (arrived.pairs, arrived.a, arrived.b, arrived.difference) == (2, 1.0, 0.5, -0.5)


def test_each_pair_is_told_with_the_worst_of_b_first() -> None:
    a = played(("one", 1, 10.0, True), ("two", 1, 10.0, True), ("three", 1, 10.0, True))
    b = played(("one", 1, 12.0, True), ("two", 1, 1.0, False), ("three", 1, 15.0, True))
    each = against(a, b).each
    assert [pair.scene for pair in each] == ["two", "three", "one"]
    assert [(pair.a["sim_s"], pair.b["sim_s"]) for pair in each] == [(10.0, 1.0), (10.0, 15.0), (10.0, 12.0)]
    assert [pair.b["arrived"] for pair in each] == [0.0, 1.0, 1.0]


def test_a_scene_with_many_seeds_counts_once() -> None:
    a = played(*(("one", seed, 10.0, True) for seed in range(9)), ("two", 0, 10.0, True))
    b = played(*(("one", seed, 11.0, True) for seed in range(9)), ("two", 0, 13.0, True))
    times = measured(against(a, b), "sim_s")
    assert (times.pairs, times.counted, times.difference) == (10, 2, 2.0)


def test_of_one_scene_each_seed_counts() -> None:
    a = played(*(("one", seed, 10.0, True) for seed in range(3)))
    b = played(*(("one", seed, 10.0 + seed, True) for seed in range(3)))
    times = measured(against(a, b), "sim_s")
    assert (times.counted, times.difference) == (3, 1.0)


def test_what_no_pair_has_has_no_difference_and_one_pair_has_no_interval() -> None:
    lost = against(played(("one", 1, 10.0, False)), played(("one", 1, 10.0, True)))
    assert (measured(lost, "sim_s").counted, measured(lost, "sim_s").difference) == (0, None)
    single = measured(against(played(("one", 1, 10.0, True)), played(("one", 1, 12.0, True))), "sim_s")
    assert (single.difference, single.low, single.high) == (2.0, None, None)


def test_an_episode_that_crashed_has_kept_no_promise() -> None:
    crashed = [outcome(ok=False, ending="crashed")]
    assert measured(against([outcome()], crashed), "no_promise_broken").b == 0.0


def test_the_interval_of_a_mean_is_that_of_a_paired_t_test() -> None:
    random = np.random.default_rng(1)
    a, b = random.normal(10.0, 2.0, 12), random.normal(11.0, 2.0, 12)
    expected = ttest_rel(b, a).confidence_interval(0.95)
    assert mean_interval(b - a) == pytest.approx((expected.low, expected.high))


def test_the_interval_of_a_share_is_that_of_agresti_and_min() -> None:
    only_a, only_b, pairs = 1, 3, 10
    apart = np.array([-1.0] * only_a + [1.0] * only_b + [0.0] * (pairs - only_a - only_b))
    c, b, n = only_a + 0.5, only_b + 0.5, pairs + 2.0
    half = 1.959964 * math.sqrt((b + c) - (b - c) ** 2 / n) / n
    assert share_interval(apart) == pytest.approx(((b - c) / n - half, (b - c) / n + half), rel=1e-6)


@pytest.mark.parametrize("p", [(0.02, 0.02), (0.1, 0.3), (0.0, 0.1)])
def test_the_interval_of_a_share_holds_the_truth_as_often_as_it_says(p: tuple[float, float]) -> None:
    random, truth = np.random.default_rng(2), p[1] - p[0]
    drawn = random.choice([-1.0, 1.0, 0.0], p=(*p, 1.0 - sum(p)), size=(2000, 30))
    held = [low <= truth <= high for low, high in map(share_interval, drawn)]
    assert np.mean(held) > 0.94


def test_equal_shares_do_not_prove_equality() -> None:
    low, high = share_interval(np.zeros(8))
    assert low < -0.1 < 0.1 < high


def test_campaigns_without_a_common_episode_or_with_an_ambiguous_one_are_refused() -> None:
    one = played(("one", 1, 10.0, True))
    with pytest.raises(UsageError, match="nothing to compare"):
        against(one, played(("two", 1, 10.0, True)))
    with pytest.raises(UsageError, match="B has two episodes of f/one, seed 1"):
        against(one, one + one)


def test_the_verb_compares_two_laws_on_the_same_scenes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, post in (("one", 0.6), ("two", -0.6)):
        scene(tmp_path / "scenes" / f"{name}.json", circles=[[3.0, post, 0.2]])
    (tmp_path / "mylaw.py").write_text(LAW)
    asked = ("campaign", "scenes", "-n", "1", "--jobs", "1")
    clew(*asked, "--out", "ours")
    clew(*asked, "--law", "mylaw.py:mine", "--out", "mine")
    shown = clew("compare", "ours", "mine")
    assert shown.exit_code == 0
    assert "time [s]" in shown.stdout
    assert "asked differently: law: A as each scene says, B mylaw.py:mine@" in shown.stdout
    assert shown.stdout.endswith("2 pairs of 2 scenes. A: ours, B: mine\n")
    cells = [
        [cell.strip() for cell in line.split("│")[1:-1]]
        for line in clew("compare", "ours", "mine", "--each").stdout.splitlines()
    ]
    pairs = [row for row in cells if row and row[0].startswith("scenes/")]
    assert {row[0] for row in pairs} == {f"scenes/{path.stem}" for path in (tmp_path / "scenes").iterdir()}
    assert {row[2] for row in pairs} == {"A B"}
    assert all(int(row[5]) < int(row[6]) for row in pairs), "steps of A and of B"
    told = json.loads(clew("compare", "ours/campaign.json", "mine", "--json").stdout)
    assert list(told["asked"]) == ["law"]
    steps = next(each for each in told["measures"] if each["measure"] == "switching_steps")
    assert steps["low"] <= steps["difference"] <= steps["high"]
    assert steps["a"] < steps["b"]

    (tmp_path / "mine" / "campaign.json").unlink()
    rest = clew("compare", "ours", "mine")
    assert rest.exit_code == 0
    assert "mine: not complete: there is no campaign.json" in rest.stderr


@pytest.mark.parametrize(
    ("place", "why"), [("none", "there is no such run or campaign"), (".", "is neither a run nor a campaign")]
)
def test_what_is_no_campaign_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str, why: str
) -> None:
    monkeypatch.chdir(tmp_path)
    refused = clew("compare", place, place)
    assert (refused.exit_code, refused.stderr.count("\n")) == (2, 1)
    assert why in refused.stderr


def test_the_verb_says_one_pair_and_two_pairs_of_one_scene(tmp_path: Path) -> None:
    for name, seeds in (("a", (1, 2, 3)), ("one", (1,)), ("two", (1, 2))):
        episodes = played(*(("s", seed, 10.0, True) for seed in seeds))
        (tmp_path / name).mkdir()
        (tmp_path / name / "campaign.json").write_bytes(msgspec.json.encode({"episodes": episodes}))
    said = [clew("compare", tmp_path / "a", tmp_path / b).stdout.splitlines()[-1] for b in ("one", "two")]
    assert [each.partition(";")[0] for each in said] == ["1 pair of 1 scene", "2 pairs of 1 scene"]
