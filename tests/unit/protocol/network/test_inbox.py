"""The inbox: arrivals from other threads, in order, bounded, with one wake-up per burst."""

from threading import Event, Thread

from hypothesis import given
from hypothesis import strategies as st

from protocol.network.inbox import Inbox
from tests.support.deadline import DEADLINE_S


def test_a_burst_wakes_once_and_the_next_burst_again() -> None:
    wakes: list[None] = []
    inbox = Inbox[int](lambda: wakes.append(None), capacity=10, bytes_max=10)
    for burst in ([1, 2, 3], [4, 5]):
        for item in burst:
            inbox.append(item, 1)
        assert inbox.drain() == burst
    assert len(wakes) == 2


def test_an_empty_inbox_drains_to_nothing() -> None:
    assert Inbox[int](lambda: None, capacity=1, bytes_max=10).drain() == []


@given(st.lists(st.one_of(st.integers(), st.just("drain")), max_size=60), st.integers(1, 8))
def test_the_newest_are_kept_in_order_and_every_item_is_drained_or_counted(
    steps: list[int | str], capacity: int
) -> None:
    inbox = Inbox[int | str](lambda: None, capacity=capacity, bytes_max=100)
    since_drain: list[int | str] = []
    drained_count = 0
    for step in [*steps, "drain"]:
        if step == "drain":
            items = inbox.drain()
            assert items == since_drain[-capacity:]
            drained_count += len(items)
            since_drain = []
        else:
            inbox.append(step, 1)
            since_drain.append(step)
    assert drained_count + inbox.dropped_count == len([step for step in steps if step != "drain"])


def test_arrivals_that_take_too_many_bytes_together_are_dropped_oldest_first_and_counted() -> None:
    inbox = Inbox[str](lambda: None, capacity=10, bytes_max=100)
    for item, size_bytes in (("a", 60), ("b", 30), ("c", 20)):
        inbox.append(item, size_bytes)
    assert (inbox.drain(), inbox.dropped_count) == (["b", "c"], 1)
    inbox.append("too large", 101)
    assert (inbox.drain(), inbox.dropped_count) == ([], 2)


def test_no_item_and_no_wake_up_is_lost_while_another_thread_appends() -> None:
    woken = Event()
    inbox = Inbox[int](woken.set, capacity=100_000, bytes_max=100_000)

    def write() -> None:
        for n in range(20_000):
            inbox.append(n, 1)

    writer = Thread(target=write)
    writer.start()
    drained: list[int] = []
    while len(drained) < 20_000:
        assert woken.wait(DEADLINE_S)
        woken.clear()
        drained += inbox.drain()
    writer.join(DEADLINE_S)
    assert drained == list(range(20_000))
