"""The relations between the times of a fleet, by name."""

import pytest

from agents.liveness.timing import ODOMETRY_S, PATIENCE_S, Timing
from tests.support.stages.one_step import under

FLEETS = (1, 5, 50, 1000, 2000)


def relations(its: Timing) -> dict[str, bool]:
    return {
        "three pings in a row are lost before a coordinator is": its.coordinator_s >= 3.0 * its.ping_s,
        "a robot that cannot hear the coordinator is left out before it raises": its.reports_s
        < its.coordinator_s,
        "a report is tried several times before it is waited for in vain": its.reports_s
        >= 5.0 * its.report_s,
        "a put is seen before it is repeated": its.put_s >= ODOMETRY_S,
        "a stuck turn is taken back before the coordinator is given up": its.turn_s <= its.stood_s,
        "a robot that is patient in its turn is not taken for a stuck one": its.turn_s > PATIENCE_S,
        "who has slept listens for longer than it slept": its.listens_s > its.gap_s,
        "a silent robot is given up before all that wait are": its.silent_s < its.stood_s,
        "nobody is given up for a pause in which all wait": its.comes_back_s < its.stood_s,
        "a raise is seen before most others are made": 2.0 * its.draws_s >= ODOMETRY_S,
    }


@pytest.mark.parametrize("robots", FLEETS)
def test_every_relation_holds_in_a_fleet_of_any_size(robots: int) -> None:
    timing = Timing.of(under("certified", robots=robots))
    for in_vain in range(timing.slower_max + 1):
        broken = [name for name, holds in relations(timing.slower(in_vain)).items() if not holds]
        assert not broken


def test_a_coordinator_of_a_large_fleet_hears_no_more_than_some_hundred_reports_a_second() -> None:
    for robots in FLEETS:
        timing = Timing.of(under("certified", robots=robots))
        assert robots / timing.ping_s <= 100.0 + 1e-9
        assert robots / timing.report_s <= 500.0
