"""Time against message loss; the page and the figure come from the same runs."""

import json
from pathlib import Path

import pytest
from msgspec.structs import replace

from clew.bench.loss import (
    BOUNDS,
    NAMES,
    RATES,
    Crossing,
    LossPoint,
    Reach,
    figures,
    loss_plan,
    rehearsed,
)
from clew.bench.result import all_met
from protocol.faults.plan import NO_FAULTS
from tests.support.campaigns import clew, scene
from world.scenario.scenario import load


def crossings(*times_s: float | None) -> tuple[Crossing, ...]:
    return tuple(Crossing(seed=seed, time_s=time_s, violations=0) for seed, time_s in enumerate(times_s, 1))


def points(seconds_at: dict[float, float | None], live_s: float | None = None) -> list[LossPoint]:
    return [
        LossPoint(reach=reach, rate=rate, rehearsed=crossings(time_s), live=crossings(live_s))
        for reach in Reach
        for rate, time_s in seconds_at.items()
    ]


MEASURED = points({rate: 20.0 + 20.0 * rate if rate < 0.8 else None for rate in RATES}, live_s=33.0)


def test_a_plan_drops_messages_between_robots_or_all_messages_and_none_at_rate_zero() -> None:
    assert loss_plan(Reach.LINKS, 0.0) == NO_FAULTS
    (links,) = loss_plan(Reach.LINKS, 0.5).rules
    (all_kinds,) = loss_plan(Reach.ALL, 0.5).rules
    assert (links.probability, all_kinds.probability) == (0.5, 0.5)
    assert set(Reach.LINKS.kinds) == {"ahead", "behind", "report", "answer", "formation", "plea"}
    assert Reach.ALL.kinds == ()


def test_the_bounds_are_for_messages_between_robots_and_at_all_rates_the_fleet_has_to_arrive() -> None:
    quick: dict[float, float | None] = {rate: 20.0 * BOUNDS.get(rate, 1.7) for rate in RATES}
    quick[0.0] = 20.0
    assert all_met(figures(points(quick)))
    for rate, slow_s in ((0.5, 22.1), (0.75, 30.1), (0.1, None), (0.9, None)):
        slow = [each for each in figures(points(quick | {rate: slow_s})) if each.met is False]
        assert [each.name for each in slow] == [f"{100.0 * rate:.0f} % of {NAMES[Reach.LINKS]} lost"]


def test_one_broken_promise_fails() -> None:
    first, *others = MEASURED
    broken = replace(first, live=(replace(first.live[0], violations=1),))
    assert [each.met for each in (figures(MEASURED)[-1], figures([broken, *others])[-1])] == [True, False]


@pytest.mark.long
def test_a_rehearsal_arrives_a_little_later_with_10_percent_loss_and_never_with_100_percent() -> None:
    scenario = load("grove", robots=2)
    whole, tenth = (rehearsed(scenario, loss_plan(Reach.ALL, rate), 1) for rate in (0.0, 0.1))
    assert whole.time_s is not None
    assert tenth.time_s is not None
    assert whole.time_s < tenth.time_s < 2.0 * whole.time_s
    nothing = rehearsed(scenario, loss_plan(Reach.LINKS, 1.0), 1)
    assert (nothing.time_s, nothing.violations) == (None, 0)


@pytest.mark.long
def test_the_verb_rehearses_every_rate_of_both_kinds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rates = (0.0, *BOUNDS)  # those that it judges by
    monkeypatch.setattr("clew.bench.loss.RATES", rates)
    told = clew("bench", "loss", scene(tmp_path / "posts.json"), "--runs", "1", "--json")
    result = json.loads(told.stdout)
    said = result["details"]
    assert [each["measured"]["repeats"] for each in result["figures"]] == [*[1] * len(said), len(said)]
    has_aim = [each["aim"] is not None for each in result["figures"]]
    assert has_aim == [True, True, True, False, False, False, True]
    assert [(point["reach"], point["rate"]) for point in said] == [
        (reach, rate) for reach in Reach for rate in rates
    ]
    assert [len(point["rehearsed"]) for point in said] == [1] * len(said)
