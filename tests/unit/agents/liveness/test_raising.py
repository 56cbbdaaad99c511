"""When a robot proposes a view."""

from hypothesis import given
from hypothesis import strategies as st

from agents.commands import Command, Note, Put
from agents.liveness.raising import Raising
from agents.liveness.reason import Reason
from agents.liveness.timing import Timing
from protocol.fence import Cause, Epoch, Fence, May, Raise
from protocol.timeline import ViewProposed

TIMING = Timing()
OWN = Reason(Cause.NEIGHBOUR_LOST, "token", 2)
SHARED = Reason(Cause.COORDINATOR_LOST, "it is silent", 1)
lives = st.integers(1, 2**63 - 1)


def fence(generation: int, may: May = May.NOBODY) -> Fence:
    return Fence(epoch=Epoch(generation=generation, robot=1, life=7), may=may)


def puts(commands: list[Command]) -> list[Raise]:
    return [each.change for each in commands if isinstance(each, Put) and isinstance(each.change, Raise)]


def waits_s(raising: Raising, told: Fence, reason: Reason = OWN) -> float:
    """For how long a robot waits from when it has a reason until it raises, in milliseconds' steps."""
    raising.enter(told)
    for step in range(10_000):
        if puts(raising.want(reason, told, step / 1000)):
            return step / 1000
    raise AssertionError("it never raises")


@given(lives, st.integers(0, 1000))
def test_after_a_view_in_vain_the_drawn_time_is_between_its_limits(life: int, generation: int) -> None:
    raising = Raising(2, life, TIMING)
    raising.enter(fence(generation, May.ALL))
    waited_s = waits_s(raising, fence(generation + 1))
    assert TIMING.draws_s <= waited_s <= 2.0 * TIMING.draws_s + 0.001


@given(lives, st.integers(0, 1000))
def test_for_what_all_may_want_it_is_drawn_from_a_longer_time(life: int, generation: int) -> None:
    raising = Raising(2, life, TIMING)
    raising.enter(fence(generation, May.ALL))
    assert waits_s(raising, fence(generation), SHARED) <= TIMING.shared_draws_s + 0.001


@given(lives, st.integers(0, 1000))
def test_over_a_strand_that_drives_a_robot_raises_at_once_for_what_few_may_want(
    life: int, generation: int
) -> None:
    raising = Raising(2, life, TIMING)
    assert waits_s(raising, fence(generation, May.ALL)) == 0.0


def test_drawn_times_differ_by_life_and_by_generation() -> None:
    for reason in (OWN, SHARED):
        drawn: dict[tuple[int, int], float] = {}
        for life in range(1, 6):
            for generation in range(5):
                raising = Raising(2, life, TIMING)
                raising.enter(fence(generation, May.ALL))
                drawn[life, generation] = raising._draw_s(reason, generation + 1)
        assert len(set(drawn.values())) == len(drawn)


def test_the_drawn_time_doubles_with_each_view_in_vain_up_to_a_limit() -> None:
    shares = []
    for in_vain in range(6):
        raising, told = Raising(2, 77, TIMING), fence(10)
        raising.enter(fence(10 - in_vain, May.ALL))
        shares.append(raising._draw_s(OWN, told.epoch.generation))
    once_s = shares[1]
    assert shares == [0.0, *(once_s * 2.0 ** (min(vain, TIMING.doublings_max) - 1) for vain in range(1, 6))]


def test_nobody_raises_over_a_stop() -> None:
    raising, stopped = Raising(2, 77, TIMING), fence(3, May.STOPPED)
    raising.enter(stopped)
    assert not [command for tenth in range(100) for command in raising.want(OWN, stopped, tenth / 10)]


def test_a_reason_that_goes_away_before_the_drawn_time_has_passed_raises_nothing() -> None:
    raising, told = Raising(2, 77, TIMING), fence(3)
    raising.enter(told)
    assert raising.want(OWN, told, 0.0) == []
    assert raising.want(None, told, 0.01) == []
    assert raising.want(OWN, told, 10.0) == [], "it waits anew"


def test_a_raise_is_repeated_until_odometry_tells_it_and_noted_once() -> None:
    raising, told = Raising(2, 77, TIMING), fence(3)
    waited_s = waits_s(raising, told)
    again = [raising.want(OWN, told, waited_s + tenth * TIMING.put_s) for tenth in range(1, 4)]
    assert [puts(each)[0].epoch for each in again] == [told.epoch.next(2, 77)] * 3
    assert not [command for each in again for command in each if isinstance(command, Note)]


def test_a_raise_goes_up_by_one_generation_and_says_why() -> None:
    raising, told = Raising(2, 77, TIMING), fence(3)
    raising.enter(told)
    raising.want(OWN, told, 0.0)
    commands = raising.want(OWN, told, 1.0)
    assert commands == [
        Note(ViewProposed(epoch=40002, cause=OWN.cause, about=2, why="token")),
        Put(Raise(epoch=Epoch(generation=4, robot=2, life=77), cause=OWN.cause)),
    ]
    assert raising.reason == OWN


def noted(commands: list[Command]) -> list[Cause]:
    records = [each.record for each in commands if isinstance(each, Note)]
    return [each.cause for each in records if isinstance(each, ViewProposed)]


def test_a_raise_for_another_reason_is_noted_and_counts_also_if_it_is_for_the_same_epoch() -> None:
    raising, told = Raising(2, 77, TIMING), fence(3, May.ALL)
    raising.enter(told)
    assert noted(raising.want(OWN, told, 0.0)) == [OWN.cause]
    other = Reason(Cause.DEAD_END, "the only way leads back")
    commands = raising.want(other, told, 1.0)
    assert (noted(commands), puts(commands)[0].cause) == ([other.cause], other.cause)
    assert raising.reason == other


def test_what_is_wanted_again_after_it_was_not_is_noted_again() -> None:
    raising, told = Raising(2, 77, TIMING), fence(3, May.ALL)
    raising.enter(told)
    assert noted(raising.want(OWN, told, 0.0)) == [OWN.cause]
    assert raising.want(None, told, 1.0) == []
    assert raising.reason == OWN, "the raise that was put may still arrive"
    assert noted(raising.want(OWN, told, 60.0)) == [OWN.cause]


def test_when_odometry_tells_a_newer_epoch_whatever_was_wanted_waits_anew() -> None:
    raising = Raising(2, 77, TIMING)
    waits_s(raising, fence(3))
    raising.enter(fence(4))
    assert raising.want(OWN, fence(4), 20.0) == []
    (put,) = puts(raising.want(OWN, fence(4), 21.0))
    assert put.epoch.generation == 5
