"""Rehearsals are timed as often as asked, each beside its lower limit."""

import itertools
import json

from clew.bench.rehearsal import figure_of, speed
from protocol.faults.plan import uniform
from tests.support.campaigns import clew
from world.scenario.scenario import load


def test_a_rehearsal_is_timed_as_often_as_asked_and_compared_with_bare_messages() -> None:
    ticking = map(float, itertools.count()).__next__
    timed = speed(load("grove"), uniform(loss=0.1), runs=3, wall=ticking)
    assert (timed.faults, timed.wall_s, timed.bare_s) == ("uniform", (1.0,) * 3, (1.0,) * 3)
    assert timed.messages > 10 * 5 * timed.sim_s  # odometry alone
    figure = figure_of(timed)
    assert (figure.measured.repeats, figure.measured.median) == (3, timed.sim_s)
    assert [base.ratio.median for base in figure.baselines] == [1.0]  # by that clock both take a second


def test_the_verb_says_how_fast_rehearsals_are() -> None:
    told = clew("bench", "rehearsal", "grove", "--runs", "1", "--faults", "loss-50", "--json")
    assert told.exit_code == 0, told.output
    result = json.loads(told.stdout)
    (row,) = result["figures"]
    assert row["name"] == "faults: loss-50"
    assert min(row["measured"]["median"], row["baselines"][0]["measured"]["median"]) > 0.0
    assert "faults: loss-50" in clew("bench", "rehearsal", "--runs", "1", "--faults", "loss-50").stdout
