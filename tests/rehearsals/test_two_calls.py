"""Schedules of an adversary in which bodies might move under two calls at once."""

from pathlib import Path

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from protocol.faults.rules import Delay, Drop, Kill, Partition, Restart, Rule
from tests.support.campaigns import scene
from world.judge.judgement import judge
from world.scenario.scenario import load


def rehearsed(tmp_path: Path, *rules: Rule, seed: int = 1) -> Rehearsal:
    """Five robots on open ground, under these rules."""
    path = scene(tmp_path / "posts.json", goal=[9.0, 0.0], bounds=[0.0, -2.0, 11.0, 2.0])
    scenario = load(str(path))
    return Rehearsal(scenario, seed, Plan(name="test", rules=rules)).run()


SCHEDULES: dict[str, tuple[Rule, ...]] = {
    # One robot is cut off from the others, whose tokens are gone for two seconds.
    "tokens that come back": (
        Partition(from_s=4.0, group=("r5",), others=("r1", "r2", "r3", "r4")),
        *(
            Partition(from_s=4.0, until_s=6.0, group=(robot,), others=("router",))
            for robot in ("r1", "r2", "r3", "r4")
        ),
    ),
    # A robot that is cut off sees all tokens go; one robot really dies just before it is back.
    "tokens that go unseen": (
        Partition(from_s=2.0, until_s=10.0, group=("r5",), others=("router",)),
        Kill(from_s=9.95, target="r4"),
    ),
    # A robot notices a death while its clock has stood still for a second and a half.
    "a clock that lags": (
        Drop(from_s=4.0, until_s=5.6, receiver=("r3",), kinds=("odometry",)),
        Kill(from_s=5.55, target="r5"),
    ),
    # The only order of a robot's former life arrives after its restart.
    "an order of a former life": (
        Delay(until_s=5.0, sender=("r1",), kinds=("drive",), delay_s_min=0.9, delay_s_max=0.92),
        Restart(from_s=0.3, target="r1"),
    ),
}


@pytest.mark.parametrize("schedule", SCHEDULES)
def test_bodies_never_move_under_two_calls_and_no_invariant_breaks(tmp_path: Path, schedule: str) -> None:
    rehearsal = rehearsed(tmp_path, *SCHEDULES[schedule])
    judgement = judge(rehearsal.world.scenario, rehearsal.entries)
    assert judgement.breaches == (), schedule
