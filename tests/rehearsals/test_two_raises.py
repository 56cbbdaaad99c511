"""Schedules of an adversary in which bodies might move in two views at once."""

from pathlib import Path

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from protocol.faults.rules import Delay, Drop, Kill, Partition, Restart, Rule
from protocol.timeline import FenceChanged, ViewProposed
from tests.support.campaigns import scene
from tests.support.long import long
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.scenario.scenario import load

ENDS_BY_S = 60.0
"""Longer than any schedule here; without it the first runs on, for one robot is cut off for good."""


def rehearsed(tmp_path: Path, *rules: Rule, seed: int = 1) -> Rehearsal:
    """Five robots on open ground, under these rules."""
    path = scene(tmp_path / "posts.json", goal=[9.0, 0.0], bounds=[0.0, -2.0, 11.0, 2.0])
    scenario = load(str(path))
    rehearsal = Rehearsal(scenario, seed, Plan(name="test", rules=rules))
    rehearsal.world.limit(ENDS_BY_S)
    return rehearsal.run()


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


@pytest.mark.parametrize("schedule", [*list(SCHEDULES)[2:], *long(list(SCHEDULES)[:2])])
def test_bodies_never_move_in_two_views_and_no_invariant_breaks(tmp_path: Path, schedule: str) -> None:
    rehearsal = rehearsed(tmp_path, *SCHEDULES[schedule])
    judgement = judge(rehearsal.world.scenario, rehearsal.entries)
    assert judgement.breaches == (), schedule


def late_raises(least_s: float, most_s: float) -> Delay:
    return Delay(until_s=6.0, kinds=("raise",), delay_s_min=least_s, delay_s_max=most_s)


@pytest.mark.parametrize(
    ("rule", "seed", "fences"),
    [
        # The greater number arrives second, while nobody has had a turn yet: it replaces the other.
        (late_raises(0.3, 0.5), 1, [(10_001, 0), (10_004, 0), (10_004, 1)]),
        # Greater numbers arrive when the strand of the first one may drive already: they change nothing.
        (late_raises(0.5, 0.9), 4, [(10_001, 0), (10_001, 1)]),
        *long([(late_raises(0.5, 0.9), 2, [(10_003, 0), (10_003, 1)])]),
    ],
)
def test_of_several_raises_of_one_generation_one_is_coordinated_and_the_fleet_arrives(
    tmp_path: Path, rule: Delay, seed: int, fences: list[tuple[int, int]]
) -> None:
    rehearsal = rehearsed(tmp_path, rule, seed=seed)
    records = [entry.record for _, entry in rehearsal.entries]
    proposed = [record.epoch for record in records if isinstance(record, ViewProposed)]
    assert len(set(proposed)) == len(proposed) > 2
    changes = [(record.epoch, record.turn) for record in records if isinstance(record, FenceChanged)]
    assert changes == fences
    assert judge(rehearsal.world.scenario, rehearsal.entries).breaches == ()
    assert rehearsal.world.ending is Ending.ARRIVED
