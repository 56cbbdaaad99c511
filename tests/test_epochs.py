from hypothesis import assume, given
from hypothesis import strategies as st

from protocol.epochs import CALLERS, COUNTS, called_epoch, is_called, of_one_call
from protocol.frames import ROBOTS_MAX

callers = st.integers(1, ROBOTS_MAX)
counts = st.integers(0, COUNTS - 1)
called = st.builds(called_epoch, st.integers(0, COUNTS * CALLERS * 1000), callers)
epochs = st.one_of(counts, st.builds(lambda epoch, count: epoch + count, called, counts))


@given(epochs, callers)
def test_a_call_is_newer_than_all_that_its_caller_has_heard_of(newest: int, caller: int) -> None:
    assert called_epoch(newest, caller) > newest


@given(epochs, callers, epochs, callers)
def test_two_robots_never_call_the_same_epoch_nor_one_that_follows_the_others(
    newest: int, caller: int, others_newest: int, other: int
) -> None:
    assume(caller != other)
    one, another = called_epoch(newest, caller), called_epoch(others_newest, other)
    assert one != another
    assert not of_one_call(one, another)


@given(epochs, callers, st.lists(callers, max_size=5))
def test_one_robot_that_remembers_never_calls_the_same_epoch_again(
    newest: int, caller: int, others: list[int]
) -> None:
    first = heard = called_epoch(newest, caller)
    for other in others:
        heard = max(heard, called_epoch(heard, other))
    assert called_epoch(heard, caller) > first


@given(called, counts, counts)
def test_epochs_that_follow_a_call_are_of_one_call_with_it(epoch: int, one: int, other: int) -> None:
    assert of_one_call(epoch + one, epoch + other)
    assert is_called(epoch + one)


@given(counts, callers)
def test_nobody_has_called_the_epochs_that_a_run_begins_in(count: int, caller: int) -> None:
    assert not is_called(count)
    assert of_one_call(count, 0)
    assert not of_one_call(count, called_epoch(count, caller))
