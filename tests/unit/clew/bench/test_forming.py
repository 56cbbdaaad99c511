"""How much work it takes until a fleet has formed, and that a robot's share does not grow with the fleet."""

import json
import time

from msgspec.structs import replace

from clew.bench.forming import BOUND_CPU_S, Forming, figures, forming
from clew.bench.result import all_met
from tests.support.campaigns import clew

GOOD = Forming(robots=200, formed_s=0.3, cpu_s=1.0, messages_per_robot=5.0, coordinator_messages=400)


def test_a_robot_of_a_large_fleet_sends_no_more_until_the_strand_has_formed() -> None:
    small, large = (forming(robots, cpu=time.process_time) for robots in (5, 100))
    assert (small.formed_s, large.formed_s) != (None, None)
    assert large.messages_per_robot <= 1.5 * small.messages_per_robot
    assert large.coordinator_messages <= 20 * small.coordinator_messages


def test_a_fleet_is_quick_if_it_forms_and_up_to_the_bound_within_its_time() -> None:
    slow = replace(GOOD, cpu_s=BOUND_CPU_S + 0.1)
    assert all_met(figures([GOOD]))
    assert not all_met(figures([GOOD, replace(GOOD, formed_s=None)]))
    assert not all_met(figures([slow]))
    assert all_met(figures([replace(slow, robots=1000)]))
    assert not all_met(figures([replace(slow, robots=1000, formed_s=None)]))


def test_the_verb_prints_a_table_or_json() -> None:
    told = clew("bench", "forming", "3", "5")
    assert told.exit_code == 0
    assert "messages per robot" in told.stdout
    result = json.loads(clew("bench", "forming", "3", "--json").stdout)
    assert [row["robots"] for row in result["details"]] == [3]
    assert [each["met"] for each in result["figures"]] == [True, None, None]
