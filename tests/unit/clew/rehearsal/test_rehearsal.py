"""Whole fleets in virtual time: a seed determines a run; loss, delay and death break no invariant.

Every failure prints the line that replays it.
"""

import itertools
from collections.abc import Callable
from functools import cache

import pytest
from msgspec.structs import replace

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import NO_FAULTS, Plan, uniform
from protocol.faults.rules import ROUTER, Kill, Partition, Rule
from protocol.keys import WORLD
from protocol.timeline import LinkSilent, RobotDied, RobotHeld, StrandFormed
from tests.support.faults import injected, kill
from tests.support.long import long
from world.core import ROUTER_PATIENCE_WALL_S
from world.judge.ending import Ending
from world.judge.judgement import Judgement, judge
from world.judge.table import measure, rms_m
from world.scenario.scenario import Scenario, load

PERFECT = NO_FAULTS
LOSSY = uniform(delay_s_max=0.3, loss=0.3, repeat=0.1)


def judged(rehearsal: Rehearsal) -> Judgement:
    return judge(rehearsal.world.scenario, rehearsal.entries)


def replay(test: Callable[..., None], *arguments: object) -> str:
    chosen = f"{test.__name__}[{'-'.join(map(str, arguments))}]"
    return f"replay with  ./launch/test.sh 'tests/unit/clew/rehearsal/test_rehearsal.py::{chosen}'"


@pytest.mark.parametrize("seed", [1, 2])
def test_the_printed_law_reproduces_table_1(seed: int) -> None:
    scenario = load("paper")
    tally = Rehearsal(scenario, seed, PERFECT).run().world.tally
    assert len(tally.switching_positions) == 11
    error_m = rms_m(measure(scenario, tally.switching_positions), scenario.table_m)
    assert error_m is not None
    assert error_m <= 0.035, replay(test_the_printed_law_reproduces_table_1, seed)


def test_the_leader_of_table_1_comes_nearest_to_obstacle_1_where_it_ends() -> None:
    scenario = load("paper")
    rehearsal = Rehearsal(scenario, 1, PERFECT).run()
    measured_m = measure(scenario, rehearsal.world.tally.switching_positions)
    nearest_m, position, obstacle = min(
        (each_m, row, column)
        for row, distances_m in enumerate(measured_m, start=1)
        for column, each_m in enumerate(distances_m, start=1)
    )
    assert (position, obstacle) == (11, 1)
    assert nearest_m == pytest.approx(0.064, abs=0.0005)
    assert judged(rehearsal).least_clearance.distance_m == pytest.approx(nearest_m, abs=1e-6)


@pytest.mark.parametrize("name", ["paper", "grove"])
def test_with_the_certified_law_the_fleet_arrives_and_breaks_no_invariant(name: str) -> None:
    rehearsal = Rehearsal(load(name, law="certified"), 1, PERFECT).run()
    judgement = judged(rehearsal)
    assert rehearsal.world.ending is Ending.ARRIVED
    assert rehearsal.world.tally.goal_reached
    assert judgement.breaches == ()
    assert judgement.least_clearance.distance_m >= 0.09


@cache
def lossy(seed: int) -> Rehearsal:
    """To read."""
    return Rehearsal(load("grove"), seed, LOSSY).run()


@pytest.mark.parametrize("seed", [1, *long([2, 3])])
def test_loss_delay_and_duplication_only_cost_time(seed: int) -> None:
    rehearsal = lossy(seed)
    again = replay(test_loss_delay_and_duplication_only_cost_time, seed)
    assert injected(rehearsal)["drop"] > 500, again
    assert injected(rehearsal)["duplicate"] > 100, again
    assert judged(rehearsal).breaches == (), again
    assert rehearsal.world.ending is Ending.ARRIVED, again


def test_a_loss_of_90_percent_breaks_no_invariant() -> None:
    deaf = uniform(delay_s_max=1.5, loss=0.9)
    rehearsal = Rehearsal(load("grove"), 1, PERFECT)
    hears = True
    for _ in itertools.takewhile(lambda now_s: now_s < 60.0, rehearsal.ticks()):
        # Starts when the strand has formed; with this loss from the start, forming alone takes very long.
        if hears and any(isinstance(entry.record, StrandFormed) for _, entry in rehearsal.entries):
            rehearsal.turn_to(deaf)
            hears = False
    assert any(isinstance(entry.record, LinkSilent) for _, entry in rehearsal.entries)
    assert judged(rehearsal).breaches == ()


@pytest.mark.parametrize(
    ("dies_at_s", "robot"), [(2.0, 1), (2.0, 5), *long([(2.0, 3), (6.5, 1), (6.5, 2), (6.5, 4)])]
)
def test_when_a_robot_dies_the_others_arrive(dies_at_s: float, robot: int) -> None:
    rehearsal = Rehearsal(load("grove"), 1, PERFECT)
    for now_s in rehearsal.ticks():
        if now_s == pytest.approx(dies_at_s):
            kill(rehearsal, robot)
    again = replay(test_when_a_robot_dies_the_others_arrive, dies_at_s, robot)
    assert rehearsal.world.ending is Ending.ARRIVED, again
    died = [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, RobotDied)]
    assert [death.robot for death in died] == [robot], again
    assert judged(rehearsal).breaches == (), again


@pytest.mark.parametrize("rule", [Kill(target=ROUTER), Partition(group=(WORLD,), others=(ROUTER,))])
def test_a_run_whose_world_never_reaches_the_router_ends(rule: Rule) -> None:
    rehearsal = Rehearsal(load("grove"), 1, Plan(name="alone", rules=(rule,)))
    last_s = max(itertools.takewhile(lambda now_s: now_s < 60.0, rehearsal.ticks()))
    assert rehearsal.world.ending is Ending.CUT_OFF
    assert last_s == pytest.approx(ROUTER_PATIENCE_WALL_S, abs=0.1)


@pytest.mark.long  # in the short form to the byte, for any hash order: `test_rehearsal_faults.py`
def test_a_seed_determines_the_whole_run() -> None:
    assert Rehearsal(load("grove"), 1, LOSSY).run().entries == lossy(1).entries
    assert lossy(1).entries != lossy(2).entries


@pytest.mark.parametrize("robots", [1, 2, 9])
def test_strands_of_one_two_and_nine_robots_arrive(robots: int) -> None:
    rehearsal = Rehearsal(spread_out(robots), 1, PERFECT).run()
    assert rehearsal.world.ending is Ending.ARRIVED
    assert judged(rehearsal).breaches == ()


def test_all_robots_agree_on_one_order() -> None:
    rehearsal = lossy(2)
    orders = {entry.record.order for _, entry in rehearsal.entries if isinstance(entry.record, StrandFormed)}
    assert len(orders) == 1
    assert sorted(*orders) == [1, 2, 3, 4, 5]


def test_a_leader_waits_for_a_follower_that_lags() -> None:
    rehearsal, seen = Rehearsal(load("grove"), 1, uniform(delay_s_max=0.6, loss=0.5)), 0
    waits = False
    for _ in rehearsal.ticks():
        waits = any(isinstance(entry.record, RobotHeld) for _, entry in rehearsal.entries[seen:])
        seen = len(rehearsal.entries)
        if waits:
            break
    assert waits
    assert judged(rehearsal).breaches == ()


def spread_out(robots: int) -> Scenario:
    """The paper's scene with another number of robots; they are points, so there is room for many."""
    return load("paper", robots=robots)


@pytest.mark.parametrize(("directions", "error_m"), [(360, 0.0535), (900, 0.0250), (7200, 0.1663)])
def test_the_error_of_the_printed_law_depends_strongly_on_the_number_of_directions(
    directions: int, error_m: float
) -> None:
    paper = load("paper")
    scenario = replace(paper, sensor=replace(paper.sensor, directions=directions))
    positions = Rehearsal(scenario, 1, PERFECT).run().world.tally.switching_positions
    assert rms_m(measure(scenario, positions), scenario.table_m) == pytest.approx(error_m, abs=1e-4)
