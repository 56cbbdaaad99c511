"""Rehearsals are timed as often as asked, each beside its lower limit; queues beside the shortest one."""

import itertools
import json

import pytest

from clew.bench.forming import queue
from clew.bench.rehearsal import PEER, Speed, figures_of, growth, speed
from protocol.faults.plan import NO_FAULTS, uniform
from tests.support.campaigns import clew


def test_a_rehearsal_is_timed_as_often_as_asked_and_compared_with_bare_messages() -> None:
    ticking = map(float, itertools.count()).__next__
    timed = speed("faults", queue(2), uniform(loss=0.1), runs=3, cpu=ticking)
    assert (timed.robots, timed.cpu_s, timed.bare_s) == (2, (1.0,) * 3, (1.0,) * 3)
    assert timed.messages > 10 * 2 * timed.sim_s  # odometry alone
    real_times, messages = figures_of(timed)
    assert (real_times.measured.repeats, real_times.measured.median) == (3, timed.sim_s)
    assert [base.ratio.median for base in real_times.baselines] == [1.0]  # by that clock both take a second
    assert messages.measured.median == timed.messages


def timed(robots: int, cpu_s: float) -> Speed:
    """Two repeats of a queue's rehearsal, by hand."""
    return Speed(
        name=f"queue of {robots}",
        robots=robots,
        faults=0,
        sim_s=20.0,
        messages=1000,
        cpu_s=(cpu_s, 2.0 * cpu_s),
        bare_s=(0.1, 0.1),
    )


@pytest.mark.parametrize(("long_cpu_s", "met"), [(100.0, True), (129.0, True), (131.0, False)])
def test_a_robot_of_a_long_queue_costs_little_more_than_one_of_a_short_one(
    long_cpu_s: float, met: bool
) -> None:
    shortest, figure = growth([timed(500, long_cpu_s), timed(5, 1.0)])
    assert (shortest.name, shortest.met) == ("queue of 5", None)
    assert figure.name == "queue of 500"
    assert figure.measured.least == pytest.approx(1000.0 * long_cpu_s / (500 * 20.0))
    assert figure.baselines[0].ratio.median == pytest.approx(long_cpu_s / 100.0)
    assert figure.met is met


def test_a_peer_simulates_as_long_as_each_repeat() -> None:
    asked: list[float] = []
    ticking = map(float, itertools.count()).__next__
    known = speed("none", queue(2), NO_FAULTS, runs=2, cpu=ticking, peer=lambda _: asked.append)
    assert asked == [known.sim_s] * 2
    names = [base.name for base in figures_of(known)[0].baselines]
    assert names == ["ticks and messages alone", PEER]


@pytest.mark.parametrize(("cpu_s", "met"), [(0.01, True), (1.0, False)])
def test_the_aim_is_for_five_robots(cpu_s: float, met: bool) -> None:
    assert figures_of(timed(5, cpu_s))[0].met is met
    assert figures_of(timed(6, cpu_s))[0].met is None


@pytest.mark.long
def test_the_verb_says_how_fast_rehearsals_are() -> None:
    options = ("--runs", "1", "--faults", "loss-50", "--queue", "2", "--queue", "3")
    told = clew("bench", "rehearsal", "grove", *options, "--json")
    assert told.exit_code == 0, told.output
    result = json.loads(told.stdout)
    names = [row["name"] for row in result["figures"]]
    assert names == [
        name for each in ("faults: loss-50", "queue of 2", "queue of 3") for name in (each,) * 2
    ] + ["queue of 2", "queue of 3"]
    row = result["figures"][0]
    assert min(row["measured"]["median"], row["baselines"][0]["measured"]["median"]) > 0.0
