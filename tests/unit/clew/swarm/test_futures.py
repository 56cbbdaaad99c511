from collections.abc import Iterator

import msgspec
import pytest

from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.futures import (
    HORIZON_S,
    Branch,
    Branches,
    branch_at,
    draw_future,
    read_branches,
    said,
)
from clew.swarm.swarm import Mode, Swarm, draw
from protocol.errors import UsageError
from tests.support.long import long

SEEDS = range(1, 9)


def begin(swarm: Swarm) -> Rehearsal:
    return Rehearsal(swarm.scenario, swarm.seed, swarm.plan)


def timeline(rehearsal: Rehearsal) -> bytes:
    return msgspec.json.encode(rehearsal.entries)


def reach(ticks: Iterator[float], branch: Branch) -> None:
    assert any(branch_at(now_s, branch.robot, branch.future) == branch for now_s in ticks)


def turn_to(run: Rehearsal, future: Swarm) -> None:
    run.turn_to(future.plan)
    run.world.limit(future.scenario.time.time_s_max)


def active(swarm: Swarm, now_s: float) -> list[str | None]:
    return [rule.name for rule in swarm.plan.rules if rule.holds(now_s, 0)]


def two_branches(seed: int) -> Branches:
    return (branch_at(1.0, 1 + seed % 3, 1), branch_at(2.5, 2, 3))


@pytest.mark.parametrize("seed", [12, *long([17])])
def test_a_run_that_turns_into_a_future_equals_one_from_the_start_to_the_byte(seed: int) -> None:
    run = begin(draw_future(seed, ()))
    ticks = run.ticks()
    first, second = two_branches(seed)
    for branches in ((first,), (first, second)):
        reach(ticks, branches[-1])
        turn_to(run, draw_future(seed, branches))
    assert list(ticks)
    assert timeline(run) == timeline(begin(draw_future(seed, (first, second))).run())
    assert timeline(run) != timeline(begin(draw_future(seed, (first,))).run())


@pytest.mark.parametrize("seed", [12, *long([17])])
def test_without_branches_a_future_is_the_episode_of_its_seed(seed: int) -> None:
    assert timeline(begin(draw_future(seed, ())).run()) == timeline(begin(draw(seed)).run())


def test_a_future_has_the_faults_of_before_and_others_from_its_branch_on() -> None:
    for seed in SEEDS:
        before, (first, *_) = draw_future(seed, ()), two_branches(seed)
        after = draw_future(seed, (first,))
        for now_s in (0.0, first.from_s / 2.0, first.from_s - 0.001):
            active = [
                [rule.name for rule in each.plan.rules if rule.holds(now_s, 0)] for each in (before, after)
            ]
            assert active[0] == active[1]
        rules = after.plan.rules
        assert rules[: len(before.plan.rules)] == before.plan.rules
        assert all(rule.from_s >= first.from_s for rule in rules[len(before.plan.rules) :])


def test_futures_differ_by_seed_instant_robot_and_number() -> None:
    plans = {
        draw_future(seed, (Branch(from_s, robot, number),)).plan_text()
        for seed in (9, 13)
        for from_s in (1.001, 2.001)
        for robot in (1, 2)
        for number in (1, 2)
    }
    assert len(plans) == 16


def test_a_future_ends_soon_after_its_last_branch_and_is_checked_for_safety() -> None:
    for seed in SEEDS:
        future = draw_future(seed, two_branches(seed))
        assert future.mode is Mode.SAFETY
        assert future.scenario.time.time_s_max == pytest.approx(2.501 + HORIZON_S)
        assert draw(seed).scenario.time.time_s_max > 40.0


def test_branches_are_read_as_they_are_said() -> None:
    branches = (Branch(3.101, 4, 2), Branch(7.401, 1, 1))
    assert said(branches) == "3.101:r4:2,7.401:r1:1"
    assert read_branches(said(branches)) == branches
    assert read_branches("") == ()


@pytest.mark.parametrize(
    "text", ["3", "3.101:2", "3.1:r1:2", "x:r1:1", "3.101:4:2", "3.101:r4:2,", "nan:r1:1", "-1.000:r1:1:1"]
)
def test_other_texts_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="--future"):
        read_branches(text)
