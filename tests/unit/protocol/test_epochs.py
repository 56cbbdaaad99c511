from hypothesis import assume, given
from hypothesis import strategies as st
from protocol.epochs import (
    AHEAD_S,
    CALLERS,
    COUNTS,
    PER_S,
    called_epoch,
    is_called,
    is_called_since,
    is_possible,
    of_one_call,
)

from protocol.frames import ROBOTS_MAX

callers = st.integers(1, ROBOTS_MAX)
counts = st.integers(0, COUNTS - 1)
times = st.floats(0.0, 100_000.0)
called = st.builds(called_epoch, st.integers(0, COUNTS * CALLERS * 1000), callers, times)
epochs = st.one_of(counts, st.builds(lambda epoch, count: epoch + count, called, counts))


@given(epochs, callers, times)
def test_a_called_epoch_is_newer_than_all_that_its_caller_knows(
    newest: int, caller: int, now_s: float
) -> None:
    assert called_epoch(newest, caller, now_s) > newest


@given(st.tuples(epochs, callers, times), st.tuples(epochs, callers, times))
def test_two_robots_never_call_the_same_epoch_or_one_that_follows_the_others(
    knows: tuple[int, int, float], other_knows: tuple[int, int, float]
) -> None:
    assume(knows[1] != other_knows[1])
    one, another = called_epoch(*knows), called_epoch(*other_knows)
    assert one != another
    assert not of_one_call(one, another)


@given(epochs, callers, times, st.lists(callers, max_size=5))
def test_a_robot_with_memory_never_calls_an_epoch_twice(
    newest: int, caller: int, now_s: float, others: list[int]
) -> None:
    first = heard = called_epoch(newest, caller, now_s)
    for other in others:
        heard = max(heard, called_epoch(heard, other, now_s))
    assert called_epoch(heard, caller, now_s) > first


@given(callers, times, st.floats(1.0 / PER_S + 0.01, 1000.0))
def test_a_restarted_robot_without_memory_never_calls_an_epoch_twice(
    caller: int, now_s: float, started_again_s: float
) -> None:
    first = called_epoch(0, caller, now_s)
    assert called_epoch(0, caller, now_s + started_again_s) > first


@given(epochs, callers, times, counts, st.floats(0.0, 1.0))
def test_calls_after_a_time_are_distinguished_from_calls_before_it(
    newest: int, caller: int, since_s: float, count: int, before_s: float
) -> None:
    after = called_epoch(newest, caller, since_s + 1.0 / PER_S + 0.01)
    assert is_called_since(after + count, since_s), "a generation later"
    before = called_epoch(0, caller, max(0.0, since_s - before_s))
    assert not is_called_since(before + count, since_s)


@given(called, counts, counts)
def test_epochs_that_follow_a_call_belong_to_that_call(epoch: int, one: int, other: int) -> None:
    assert of_one_call(epoch + one, epoch + other)
    assert is_called(epoch + one)


@given(counts, callers, times)
def test_the_first_epochs_of_a_run_are_not_called(count: int, caller: int, now_s: float) -> None:
    assert not is_called(count)
    assert of_one_call(count, 0)
    assert not of_one_call(count, called_epoch(count, caller, now_s))


@given(callers, times, counts, st.integers(0, round(AHEAD_S * PER_S) - 2))
def test_epochs_are_possible_if_calls_are_no_faster_than_the_message_rate(
    caller: int, now_s: float, count: int, heard: int
) -> None:
    newest = (int(now_s * PER_S) + heard) * COUNTS * CALLERS
    assert is_possible(called_epoch(newest, caller, now_s) + count, now_s)


@given(times)
def test_an_epoch_that_leaves_no_number_for_a_later_call_is_not_possible(now_s: float) -> None:
    assert not is_possible(2**53, now_s)
    assert not is_possible(called_epoch(0, 1, now_s + AHEAD_S + 1.0), now_s)
