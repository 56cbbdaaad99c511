"""The outbox: over a channel that loses, repeats and reorders, every entry arrives once and in order."""

from collections.abc import Iterable, Iterator
from random import Random
from typing import Generic, TypeVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.network.outbox import Outbox
from protocol.timeline import Entry, MessageRefused, Record, RouteLost
from protocol.wire.codec import SIZE_MAX_BYTES, encode
from protocol.wire.messages import BATCH_ENTRIES_MAX, LogBatch, Logged

RESEND_S = 0.5
T = TypeVar("T")


class Recorder:
    """The receiver by docs/run.md: it keeps the contiguous prefix and acknowledges its end."""

    def __init__(self) -> None:
        self.written: list[Entry] = []

    def hear(self, batch: LogBatch) -> int:
        for entry in batch.entries:
            if entry.n == len(self.written) + 1:
                self.written.append(entry)
        return len(self.written)


def numbers(batch: LogBatch | None) -> list[int]:
    return [] if batch is None else [entry.n for entry in batch.entries]


def filled(count: int, *, reason: str = "", capacity: int = 10_000) -> Outbox:
    outbox = Outbox(resend_s=RESEND_S, capacity=capacity)
    for _ in range(count):
        outbox.add(RouteLost(reason=reason), t_s=0.0, hlc="")
    return outbox


def all_batches(outbox: Outbox, now_s: float) -> Iterator[LogBatch]:
    while (batch := outbox.batch(now_s)) is not None:
        yield batch


class Channel(Generic[T]):
    """While faulty, it loses, repeats, delays and reorders messages."""

    def __init__(self, random: Random) -> None:
        self._random = random
        self._held: list[T] = []

    def carry(self, items: Iterable[T], *, faulty: bool) -> list[T]:
        for item in items:
            self._held += [item] * (self._random.choice((0, 1, 2)) if faulty else 1)
        self._random.shuffle(self._held)
        count = self._random.randint(0, len(self._held)) if faulty else len(self._held)
        arrived, self._held = self._held[:count], self._held[count:]
        return arrived


@given(
    adds=st.lists(st.integers(0, 5), max_size=20),
    faulty_rounds=st.integers(0, 30),
    random=st.randoms(use_true_random=False),
)
def test_every_entry_arrives_once_in_order_over_a_channel_that_loses_repeats_and_reorders(
    adds: list[int], faulty_rounds: int, random: Random
) -> None:
    outbox, recorder = filled(0), Recorder()
    forth, back = Channel[LogBatch](random), Channel[int](random)
    said: list[Record] = []
    for round_number in range(faulty_rounds + len(adds) + 10):
        faulty = round_number < faulty_rounds
        for _ in range(adds[round_number] if round_number < len(adds) else 0):
            said.append(RouteLost(reason=f"{len(said)}"))
            outbox.add(said[-1], t_s=0.0, hlc="")
        sent = all_batches(outbox, now_s=round_number * RESEND_S / 2)
        acknowledgements = [recorder.hear(batch) for batch in forth.carry(sent, faulty=faulty)]
        for up_to in back.carry(acknowledgements, faulty=faulty):
            outbox.acknowledged(Logged(up_to=up_to))
    assert len(outbox) == 0
    assert [entry.record for entry in recorder.written] == said
    assert [entry.n for entry in recorder.written] == list(range(1, len(said) + 1))


def test_entries_are_sent_once_until_the_resend_time() -> None:
    outbox = filled(3)
    assert numbers(outbox.batch(0.0)) == [1, 2, 3]
    assert outbox.batch(0.49) is None
    assert numbers(outbox.batch(0.5)) == [1, 2, 3]


def test_a_new_entry_goes_out_at_once_and_does_not_wait_for_an_old_one() -> None:
    outbox = filled(1)
    assert numbers(outbox.batch(0.0)) == [1]
    outbox.add(RouteLost(reason=""), t_s=0.0, hlc="")
    assert numbers(outbox.batch(0.1)) == [2]


def test_later_entries_are_sent_again_with_a_resent_entry_and_a_batch_is_consecutive() -> None:
    outbox = filled(1)
    outbox.batch(0.0)
    outbox.add(RouteLost(reason=""), t_s=0.0, hlc="")
    outbox.batch(0.3)
    outbox.add(RouteLost(reason=""), t_s=0.0, hlc="")
    assert [numbers(batch) for batch in all_batches(outbox, 0.5)] == [[1, 2, 3]]


def test_after_one_lost_batch_the_next_resend_sends_all_entries_and_no_entry_lags_later() -> None:
    outbox, recorder = filled(0), Recorder()
    for turn in range(30):
        outbox.add(RouteLost(reason=""), t_s=0.0, hlc="")
        for batch in all_batches(outbox, turn * RESEND_S / 5.0):
            if turn > 0:  # the first is lost
                outbox.acknowledged(Logged(up_to=recorder.hear(batch)))
        assert (len(outbox) == 0) is (turn >= 5)


def test_an_acknowledged_entry_is_not_sent_again() -> None:
    outbox = filled(3)
    outbox.batch(0.0)
    outbox.acknowledged(Logged(up_to=2))
    assert numbers(outbox.batch(1.0)) == [3]
    outbox.acknowledged(Logged(up_to=3))
    assert outbox.batch(2.0) is None
    assert len(outbox) == 0


def test_an_old_acknowledgement_changes_nothing() -> None:
    outbox = filled(3)
    outbox.batch(0.0)
    outbox.acknowledged(Logged(up_to=2))
    outbox.acknowledged(Logged(up_to=1))
    assert numbers(outbox.batch(1.0)) == [3]


def test_an_acknowledgement_of_another_incarnation_changes_nothing() -> None:
    outbox = Outbox("second")
    outbox.add(RouteLost(reason=""), t_s=0.0, hlc="")
    batch = outbox.batch(0.0)
    assert batch is not None
    assert batch.incarnation == "second"
    outbox.acknowledged(Logged(incarnation="first", up_to=1))
    assert len(outbox) == 1
    outbox.acknowledged(Logged(incarnation="second", up_to=1))
    assert len(outbox) == 0


def test_an_entry_that_was_never_sent_cannot_be_acknowledged() -> None:
    outbox = filled(2)
    outbox.acknowledged(Logged(up_to=10))
    assert numbers(outbox.batch(0.0)) == [1, 2]


@pytest.mark.parametrize("reason", ["", "x" * 2000])
def test_every_batch_fits_into_a_message(reason: str) -> None:
    batches = list(all_batches(filled(600, reason=reason), 0.0))
    assert [n for batch in batches for n in numbers(batch)] == list(range(1, 601))
    assert all(len(batch.entries) <= BATCH_ENTRIES_MAX for batch in batches)
    assert all(len(encode(batch, 2**53)) <= SIZE_MAX_BYTES for batch in batches)


def test_a_full_outbox_counts_refused_entries_and_leaves_no_gap() -> None:
    outbox = filled(5, capacity=3)
    assert outbox.lost_count == 2
    assert numbers(outbox.batch(0.0)) == [1, 2, 3]
    outbox.acknowledged(Logged(up_to=3))
    outbox.add(RouteLost(reason=""), t_s=0.0, hlc="")
    assert numbers(outbox.batch(0.0)) == [4]


def test_an_outbox_that_is_full_in_bytes_counts_refused_entries_and_has_room_again_later() -> None:
    outbox = Outbox(resend_s=RESEND_S, bytes_max=5_000)
    for _ in range(4):
        outbox.add(RouteLost(reason="x" * 2000), t_s=0.0, hlc="")
    assert (len(outbox), outbox.lost_count) == (2, 2)
    outbox.add(RouteLost(reason=""), t_s=0.0, hlc="")
    assert numbers(outbox.batch(0.0)) == [1, 2, 3]
    outbox.acknowledged(Logged(up_to=1))
    outbox.add(RouteLost(reason="x" * 2000), t_s=0.0, hlc="")
    assert (numbers(outbox.batch(0.0)), outbox.lost_count) == ([4], 2)


def test_refused_messages_leave_half_of_the_room_to_what_the_process_itself_has_to_say() -> None:
    outbox = filled(0, capacity=10)
    for _ in range(1000):  # a peer floods us with junk
        outbox.add(MessageRefused(key="view/r2/r1", reason="junk"), t_s=0.0, hlc="")
    for _ in range(5):
        outbox.add(RouteLost(reason=""), t_s=0.0, hlc="")
    (batch,) = all_batches(outbox, 0.0)
    assert [type(entry.record) for entry in batch.entries] == [MessageRefused] * 5 + [RouteLost] * 5
    assert outbox.lost_count == 995
