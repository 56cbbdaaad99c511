"""Whole fleets in dead ends, in virtual time: the strand turns round, and no invariant breaks.

Every failure prints the line that replays it.
"""

from collections import defaultdict
from collections.abc import Callable
from functools import partial

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import NO_FAULTS, Plan, uniform
from protocol.keys import WORLD
from protocol.timeline import (
    OrderAccepted,
    PoseSampled,
    StrandFormed,
    StrandJoined,
    StrandReversed,
)
from tests.support.faults import kill
from tests.support.long import long
from tests.support.scenes.dead_ends import EPSILON_M, RADIUS_M, box, goal_behind, nested, pocket, t_junction
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.scenario.scenario import Scenario

PERFECT = NO_FAULTS
LOSSY = uniform(delay_s_max=0.3, loss=0.3, repeat=0.1)
DEAF = uniform(delay_s_max=1.5, loss=0.9)

Build = Callable[[int], Scenario]
LONG_ARM_M, SHORT_ARM_M = 2.4, 1.2  # a queue of five robots is 1.4 m long, one of nine 2.6 m

SCENES: dict[str, Build] = {
    "a dead end longer than the strand": partial(t_junction, arm_m=LONG_ARM_M),
    "a dead end shorter than the strand": partial(t_junction, arm_m=SHORT_ARM_M),
    "dead ends within dead ends": nested,
    "a pocket of straight walls": partial(pocket, convex=True),
    "a pocket in one piece": partial(pocket, convex=False),
    "a goal behind the queue": goal_behind,
}
TURNS = ["a dead end shorter than the strand", "dead ends within dead ends", "a goal behind the queue"]
CLOSED: dict[str, Build] = {
    "no gap": partial(box, gap_m=0.0),
    "a gap 5 % too narrow": partial(box, gap_m=0.95 * 2.0 * (RADIUS_M + EPSILON_M)),
}


def replay(test: Callable[..., None], *arguments: object) -> str:
    chosen = f"{test.__name__}[{'-'.join(map(str, arguments))}]"
    return f"replay with  ./launch/test.sh 'tests/rehearsals/test_dead_ends.py::{chosen}'"


def broken(rehearsal: Rehearsal) -> list[str]:
    """All broken invariants, and all broken rules of turning round."""
    breaches = judge(rehearsal.world.scenario, rehearsal.entries).breaches
    return [*map(str, breaches), *fences_mixed(rehearsal), *epochs_gone_back(rehearsal)]


def fences_mixed(rehearsal: Rehearsal) -> list[str]:
    """Robots that moved by an order of an older turn than another robot's order to drive.

    A body is also sampled when it stops; an order at that very time does not count.
    """
    mixed, turn = [], defaultdict[int, tuple[int, int]](lambda: (0, 0))
    begun_s: dict[tuple[int, int], float] = {}
    last: dict[int, tuple[float, float]] = {}
    for source, entry in rehearsal.entries:
        if source != WORLD:
            continue
        match entry.record:
            case OrderAccepted() as order if order.target is not None:
                turn[order.robot] = (order.epoch, order.turn)
                begun_s.setdefault((order.epoch, order.turn), entry.t_s)
            case PoseSampled() as pose:
                moved = last.get(pose.robot) not in (None, (pose.x_m, pose.y_m))
                last[pose.robot] = (pose.x_m, pose.y_m)
                later_s = [at_s for each, at_s in begun_s.items() if each > turn[pose.robot]]
                if moved and min(later_s, default=entry.t_s) < entry.t_s:
                    mixed.append(f"{entry.t_s} s: robot {pose.robot} moves under {turn[pose.robot]}")
            case _:
                pass
    return mixed


def epochs_gone_back(rehearsal: Rehearsal) -> list[str]:
    """Robots that made or joined a strand of an epoch that is not newer than their last one."""
    known, gone = defaultdict[tuple[str, type], int](int), []
    for source, entry in rehearsal.entries:
        if isinstance(entry.record, StrandFormed | StrandJoined):
            key, epoch = (source, type(entry.record)), entry.record.epoch
            if epoch <= known[key]:
                gone.append(f"{source} went from epoch {known[key]} to {epoch}")
            known[key] = epoch
    return gone


def formations(rehearsal: Rehearsal) -> list[StrandFormed]:
    return [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, StrandFormed)]


def reversals(rehearsal: Rehearsal) -> list[StrandReversed]:
    return [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, StrandReversed)]


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("robots", [1, *long([5])])
def test_a_strand_gets_out_of_dead_ends(robots: int, scene: str) -> None:
    rehearsal = Rehearsal(SCENES[scene](robots), 1, PERFECT).run()
    again = replay(test_a_strand_gets_out_of_dead_ends, robots, scene)
    assert broken(rehearsal) == [], again
    assert rehearsal.world.ending is Ending.ARRIVED, again


TURNING = [(2, TURNS[1]), *long([(2, TURNS[0]), (2, TURNS[2]), (9, TURNS[1])])]


@pytest.mark.parametrize(("robots", "scene"), TURNING)
def test_in_a_corridor_one_robot_wide_the_strand_turns_round(robots: int, scene: str) -> None:
    rehearsal = Rehearsal(SCENES[scene](robots), 1, PERFECT).run()
    again = replay(test_in_a_corridor_one_robot_wide_the_strand_turns_round, robots, scene)
    assert reversals(rehearsal), again
    assert broken(rehearsal) == [], again
    assert rehearsal.world.ending is Ending.ARRIVED, again


def test_with_the_goal_behind_the_queue_the_tail_becomes_the_leader() -> None:
    rehearsal = Rehearsal(goal_behind(5), 1, PERFECT).run()
    assert [each.order for each in formations(rehearsal)] == [(1, 2, 3, 4, 5), (5, 4, 3, 2, 1)]


@pytest.mark.parametrize("scene", [TURNS[0], *long(TURNS[1:])])
@pytest.mark.parametrize("seed", [1])
def test_loss_delay_and_duplication_only_cost_time_while_turning(seed: int, scene: str) -> None:
    rehearsal = Rehearsal(SCENES[scene](3), seed, LOSSY).run()
    again = replay(test_loss_delay_and_duplication_only_cost_time_while_turning, seed, scene)
    assert broken(rehearsal) == [], again
    assert rehearsal.world.ending is Ending.ARRIVED, again


@pytest.mark.long  # in the short form a loss of 80 %, in `test_turning.py`
@pytest.mark.parametrize("scene", TURNS)
@pytest.mark.parametrize("seed", [1])
def test_a_loss_of_90_percent_while_turning_breaks_no_invariant(seed: int, scene: str) -> None:
    rehearsal = Rehearsal(SCENES[scene](3), seed, PERFECT)
    hears = True
    for _ in rehearsal.ticks():
        # Starts when the strand begins to turn; with this loss from the start it hardly gets there.
        if hears and reversals(rehearsal):
            rehearsal.turn_to(DEAF)
            hears = False
    again = replay(test_a_loss_of_90_percent_while_turning_breaks_no_invariant, seed, scene)
    assert len(formations(rehearsal)) > 1, again
    assert broken(rehearsal) == [], again


@pytest.mark.parametrize("scene", CLOSED)
@pytest.mark.parametrize(
    ("plan", "robots"),
    [
        pytest.param(PERFECT, 1, id="perfect-1"),
        pytest.param(LOSSY, 5, id="lossy-5"),
        pytest.param(PERFECT, 5, id="perfect-5", marks=pytest.mark.long),
        pytest.param(LOSSY, 1, id="lossy-1", marks=pytest.mark.long),
    ],
)
def test_without_a_way_the_run_ends_with_route_lost(plan: Plan, robots: int, scene: str) -> None:
    rehearsal = Rehearsal(CLOSED[scene](robots), 1, plan).run()
    again = replay(
        test_without_a_way_the_run_ends_with_route_lost,
        "lossy" if plan is LOSSY else "perfect",
        robots,
        scene,
    )
    assert broken(rehearsal) == [], again
    assert rehearsal.world.ending is Ending.ROUTE_LOST, again


@pytest.mark.parametrize("robot", [1, *long([2, 3])])
@pytest.mark.parametrize(
    ("plan", "after_s"),
    [
        pytest.param(PERFECT, 0.0, id="at once", marks=pytest.mark.long),
        pytest.param(LOSSY, 0.06, id="soon"),
        pytest.param(PERFECT, 4.0, id="late"),
    ],
)
def test_a_death_while_the_strand_turns_breaks_no_invariant(plan: Plan, after_s: float, robot: int) -> None:
    rehearsal = Rehearsal(t_junction(3, arm_m=SHORT_ARM_M), 1, plan)
    dies_at_s = None
    for now_s in rehearsal.ticks():
        if dies_at_s is None and reversals(rehearsal):
            dies_at_s = now_s + after_s
        if dies_at_s is not None and now_s >= dies_at_s:
            kill(rehearsal, robot)
            dies_at_s = float("inf")
    test = test_a_death_while_the_strand_turns_breaks_no_invariant
    again = replay(test, {0.0: "at once", 0.06: "soon", 4.0: "late"}[after_s], robot)
    assert rehearsal.world.ending in {Ending.ARRIVED, Ending.ROUTE_LOST, Ending.STRANDED}, again
    assert broken(rehearsal) == [], again
