"""The monitor between fleets, and the second judge on the same ways."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from clew.judge.poses import judge_between
from clew.judge.truth import Floats, Truth, read
from tests.support.judges import poses, scenario, written
from world.judge.between import Between

RADIUS_M, STEP_M = 0.1, 0.02
FLEETS = {"a": (2, RADIUS_M), "b": (1, RADIUS_M)}


def watched(ways_m: Floats) -> Between:
    """What the monitor finds of ways (ticks + 1, 3, 2): two robots of a, one of b."""
    between = Between(FLEETS)
    for tick, (starts_m, ends_m) in enumerate(pairwise(ways_m), start=1):
        between.watch(starts_m, ends_m, t_s=0.02 * tick)
    return between


def truth(*ways: Floats) -> Truth:
    """What the second judge reads of robots 1, 2 and so on: rows of t, x, y."""
    rows = [entry for robot, way in enumerate(ways, start=1) for entry in poses(robot, *way.tolist())]
    return read(written(rows, scenario()))


def head_on(aside_m: float) -> Floats:
    """Robot 1 of each fleet drives towards the other's start, past each other so far aside."""
    x = np.linspace(0.0, 2.0, 101)
    stands = np.tile([0.0, 9.0], (101, 1))
    return np.stack(
        [np.stack([x, 0.0 * x], axis=1), stands, np.stack([2.0 - x, 0.0 * x + aside_m], axis=1)], axis=1
    )


def test_two_robots_that_pass_have_the_distance_at_which_they_pass() -> None:
    least = watched(head_on(0.3)).least
    assert least is not None
    assert least.distance_m == pytest.approx(0.1)
    assert (least.fleet, least.robot, least.other_fleet, least.other) == ("a", 1, "b", 1)
    assert least.t_s == pytest.approx(1.0, abs=0.021)


def test_a_contact_counts_once_and_robots_of_one_fleet_do_not_count() -> None:
    between = watched(head_on(0.19))
    assert [(each.fleet, each.robot, each.other) for each in between.contacts] == [("a", 1, 1)]
    together = head_on(5.0)
    together[:, 1] = together[:, 0]  # both robots of a in one place: S2 of that fleet judges them
    assert watched(together).contacts == []


def test_robots_that_meet_between_two_looks_are_found() -> None:
    ways = np.array([[[0.0, 0.0], [0.0, 9.0], [1.0, 0.05]], [[1.0, 0.0], [0.0, 9.0], [0.0, 0.05]]])
    assert len(watched(ways).contacts) == 1


@given(st.integers(0, 2**32 - 1))
def test_leaving_out_far_pairs_changes_nothing_and_the_second_judge_agrees(seed: int) -> None:
    random = np.random.default_rng(seed)
    headings = random.uniform(-math.pi, math.pi, (60, 3)).cumsum(axis=0) / 8.0
    steps_m = STEP_M * random.integers(0, 2, (60, 3, 1)) * np.stack([np.cos(headings), np.sin(headings)], -1)
    starts_m = random.uniform(-0.7, 0.7, (1, 3, 2))
    ways_m = np.concatenate([starts_m, starts_m + steps_m.cumsum(axis=0)])
    found = watched(ways_m)
    every = Between(FLEETS)
    least_m = math.inf
    for one, other in pairwise(ways_m):
        tick = Between(FLEETS)
        tick.watch(one, other, t_s=0.0)
        assert tick.least is not None
        least_m = min(least_m, tick.least.distance_m)
        every.watch(one, other, t_s=0.0)
    assert found.least is not None
    assert found.least.distance_m == pytest.approx(least_m, abs=1e-12)
    times = 0.02 * np.arange(len(ways_m))[:, None]
    rows = [np.hstack([times, ways_m[:, row]]) for row in range(3)]
    runs = {fleet: truth(*(rows[row] for row in robots)) for fleet, robots in (("a", (0, 1)), ("b", (2,)))}
    second = judge_between(runs)
    assert second[0].distance_m == pytest.approx(least_m, abs=1e-9)
    assert sum(each.distance_m <= 0.0 for each in second) == len(found.contacts)


MANY = {f"f{row}": (3, RADIUS_M) for row in range(6)}


@given(st.integers(0, 2**32 - 1))
def test_to_compare_only_pairs_that_were_near_lately_finds_what_a_look_at_all_pairs_finds(seed: int) -> None:
    """On ground far larger than the look ahead, and for longer than one look ahead lasts."""
    random = np.random.default_rng(seed)
    headings = random.uniform(-math.pi, math.pi, (1, 18, 1)) + 0.05 * random.standard_normal(
        (150, 18, 1)
    ).cumsum(0)
    steps_m = (
        0.1 * random.uniform(0.0, 1.0, (1, 18, 1)) * np.concatenate([np.cos(headings), np.sin(headings)], -1)
    )
    starts_m = random.uniform(-6.0, 6.0, (1, 18, 2))
    ways_m = np.concatenate([starts_m, starts_m + steps_m.cumsum(axis=0)])
    kept, least_m, contacts = Between(MANY), math.inf, set[tuple[str, int, str, int]]()
    for starts, ends in pairwise(ways_m):
        kept.watch(starts, ends, t_s=0.0)
        fresh = Between(MANY)
        fresh.watch(starts, ends, t_s=0.0)
        assert fresh.least is not None
        least_m = min(least_m, fresh.least.distance_m)
        contacts |= {(each.fleet, each.robot, each.other_fleet, each.other) for each in fresh.contacts}
        assert kept.least is not None
        assert kept.least.distance_m == least_m
    assert {(each.fleet, each.robot, each.other_fleet, each.other) for each in kept.contacts} == contacts
