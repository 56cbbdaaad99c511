"""The relations between the times of a fleet, by name: each holds, and each can be broken."""

import re
from dataclasses import replace

import pytest

from agents.liveness.timing import ODOMETRY_S, PATIENCE_S, Timing
from tests.support.stages.one_step import under

FLEETS = (1, 5, 50, 1000, 2000)
BREAKS = {
    "three pings in a row are lost before a coordinator is": {"ping_s": 1.0},
    "a robot that cannot hear the coordinator is left out before it raises": {"reports_s": 1.5},
    "a report is tried several times before it is waited for in vain": {"report_s": 0.5},
    "a put is seen before it is repeated": {"put_s": 0.9 * ODOMETRY_S},
    "a stuck turn is taken back before the coordinator is given up": {"turn_s": 21.0},
    "a robot that is patient in its turn is not taken for a stuck one": {"turn_s": PATIENCE_S},
    "who has slept listens for longer than it slept": {"listens_s": 0.8},
    "a silent robot is given up before all that wait are": {"silent_s": 20.0},
    "nobody is given up for a pause in which all wait": {"comes_back_s": 20.0},
    "a raise is seen before most others are made": {"draws_s": 0.4 * ODOMETRY_S},
}
"""For each relation times that break it, and no other relation."""


@pytest.mark.parametrize("robots", FLEETS)
def test_every_relation_holds_in_a_fleet_of_any_size(robots: int) -> None:
    timing = Timing.of(under("certified", robots=robots))
    for in_vain in range(timing.slower_max + 1):
        assert all(timing.slower(in_vain).relations().values())


@pytest.mark.parametrize("name", sorted(BREAKS))
def test_times_that_do_not_fit_together_are_refused_by_name(name: str) -> None:
    with pytest.raises(ValueError, match=re.escape(name)):
        replace(Timing(), **BREAKS[name])  # type: ignore[arg-type]  # the fields are data


def test_every_relation_has_been_seen_broken() -> None:
    assert set(Timing().relations()) == set(BREAKS)


def test_a_coordinator_of_a_large_fleet_hears_no_more_than_some_hundred_reports_a_second() -> None:
    for robots in FLEETS:
        timing = Timing.of(under("certified", robots=robots))
        assert robots / timing.ping_s <= 100.0 + 1e-9
        assert robots / timing.report_s <= 500.0
