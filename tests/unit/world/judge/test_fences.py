"""F3 in the sequence of fences: each lawful change, and each unlawful one."""

import pytest
from msgspec.structs import replace

from protocol.fence import Cause, May
from protocol.keys import WORLD
from protocol.timeline import Entry, FenceChanged
from tests.support.histories.fenced import FIRST, SECOND, fence
from world.judge.rules.fences import FenceOrder, Fences
from world.judge.rules.rule import Dated

OPERATOR = 20_000  # generation 2, robot 0
RAISED = fence(FIRST, 0, cause=Cause.START)
LEASE = fence(FIRST, 1, May.ONE, named=3)
NOBODY = fence(FIRST, 2)
DRIVEN = fence(FIRST, 3, May.ALL, named=1, members=3)
AGAIN = fence(SECOND, 0, cause=Cause.PLEA)
STOP = fence(OPERATOR, 0, May.STOPPED, cause=Cause.OPERATOR)
RELEASED = fence(OPERATOR + 10_000, 0, cause=Cause.OPERATOR)
RESTARTED = fence(OPERATOR, 0, cause=Cause.WORLD_RESTARTED)


def complaints(*changes: FenceChanged) -> list[str]:
    rule, found = FenceOrder(), list[Dated]()
    for n, change in enumerate(changes, start=1):
        found += rule.hear(WORLD, Entry(n=n, t_s=float(n), hlc="", record=change))
    assert {breach.invariant for _, breach in found} <= {"F3"}
    return [breach.why for _, breach in found]


LAWFUL: dict[str, tuple[FenceChanged, ...]] = {
    "turns, then the next generation": (RAISED, LEASE, NOBODY, DRIVEN, AGAIN),
    "one lease after another": (RAISED, LEASE, replace(LEASE, turn=2, named=1, named_life="1a")),
    "a higher number in the same generation, at turn 0": (RAISED, fence(10_003, 0, cause=Cause.START)),
    "a stop and its release": (RAISED, LEASE, STOP, RELEASED, fence(30_001, 0, cause=Cause.PLEA)),
    "a world that was started again": (RAISED, RESTARTED, fence(SECOND, 0, cause=Cause.COORDINATOR_LOST)),
    "a stop that a restarted world keeps": (RAISED, STOP, replace(STOP, epoch=OPERATOR + 10_000)),
}


@pytest.mark.parametrize("changes", LAWFUL.values(), ids=LAWFUL.keys())
def test_fences_that_go_forward_are_lawful(changes: tuple[FenceChanged, ...]) -> None:
    assert complaints(*changes) == []


UNLAWFUL: dict[str, tuple[str, tuple[FenceChanged, ...]]] = {
    "a turn is left out": ("follows turn 1", (RAISED, LEASE, DRIVEN)),
    "a turn goes back": ("follows turn 2", (RAISED, LEASE, NOBODY, LEASE)),
    "a turn after ALL": ("the last of its epoch", (RAISED, LEASE, NOBODY, DRIVEN, fence(FIRST, 4))),
    "a turn after a stop": ("the last of its epoch", (RAISED, STOP, replace(STOP, turn=1, may=May.NOBODY))),
    "a turn of another life": ("another life", (RAISED, replace(LEASE, life="ff"))),
    "a turn of another robot": ("another life", (RAISED, replace(LEASE, coordinator=1))),
    "a turn that stops": ("only the operator", (RAISED, replace(NOBODY, turn=1, may=May.STOPPED))),
    "a lease of nobody": ("names no life", (RAISED, replace(LEASE, named=0))),
    "a lease without a life": ("names no life", (RAISED, replace(LEASE, named_life=""))),
    "a lower number in the same generation": ("replaces", (RAISED, fence(10_001, 0, cause=Cause.START))),
    "a higher number after a turn": ("replaces", (RAISED, LEASE, fence(10_003, 0, cause=Cause.START))),
    "two generations at once": ("generation", (RAISED, fence(30_003, 0, cause=Cause.PLEA))),
    "an older generation": ("generation", (RAISED, AGAIN, RAISED)),
    "raised over a stop": ("over a stop", (RAISED, STOP, fence(30_001, 0, cause=Cause.PLEA))),
    "an epoch that begins with a turn": ("begins with turn 1", (RAISED, replace(AGAIN, turn=1))),
    "an epoch that begins with a lease": ("begins with turn 0", (RAISED, replace(AGAIN, may=May.ONE))),
    "a robot that stops all": ("only the operator", (RAISED, replace(AGAIN, may=May.STOPPED))),
    "a coordinator that did not propose": ("its coordinator", (RAISED, replace(AGAIN, coordinator=1))),
    "a coordinator without a life": ("its coordinator", (RAISED, replace(AGAIN, life=""))),
    "an operator with a life": ("its coordinator", (RAISED, replace(STOP, life="ff"))),
    "no cause": ("no cause", (RAISED, replace(AGAIN, cause=None))),
}


@pytest.mark.parametrize(("why", "changes"), UNLAWFUL.values(), ids=UNLAWFUL.keys())
def test_each_unlawful_change_of_the_fence_is_found(why: str, changes: tuple[FenceChanged, ...]) -> None:
    (said,) = complaints(*changes)
    assert why in said


def test_the_fence_of_an_interval_is_the_one_after_its_beginning_and_before_its_end() -> None:
    fences = Fences()
    for t_s, change in ((1.0, RAISED), (2.0, LEASE), (2.0, NOBODY), (3.0, DRIVEN)):
        fences.hear(t_s, change)
    assert list(fences.during(0.0, 1.0)) == [0]
    assert list(fences.during(1.0, 2.0)) == [1]
    assert list(fences.during(1.5, 2.5)) == [1, 2, 3]
    assert list(fences.during(2.0, 3.0)) == [3]
    assert list(fences.during(3.0, 9.0)) == [4]


def test_when_an_epoch_began_and_when_its_strand_might_drive() -> None:
    fences = Fences()
    for t_s, change in ((1.0, RAISED), (2.0, LEASE), (3.0, NOBODY), (4.0, DRIVEN), (5.0, AGAIN)):
        fences.hear(t_s, change)
    assert (fences.begun_s(FIRST), fences.begun_s(SECOND), fences.begun_s(7)) == (1.0, 5.0, float("inf"))
    assert (fences.all_of(FIRST), fences.all_of(SECOND), fences.all_of(0)) == (4, None, None)
