"""The engine on systems so small that what it has to find can be counted by hand."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from math import comb
from typing import NamedTuple

import pytest

from clew.explore.explorable import Breach, Fault
from clew.explore.search import Ended, Exploration, Explored, deepen, retell


class Told(NamedTuple):
    """What a receiver has done with the messages 0, 1, 2 ... of its sender, and which are late."""

    sent: int
    did: tuple[str, ...]
    late: tuple[int, ...] = ()


@dataclass(frozen=True)
class Receiver:
    """Gets messages, each of which may be lost or come twice. It remembers the order, or only how often."""

    messages: int
    remembers: bool

    def start(self) -> Told:
        return Told(0, ())

    def rank(self, state: Told) -> tuple[int, ...]:
        return (state.sent,)

    def follow(self, state: Told) -> Told | None:
        return None if state.sent == self.messages else self._done(state, "heard")

    def hurry(self, state: Told) -> Told | None:
        return self.follow(state)

    def is_open(self, state: Told) -> bool:
        return state.sent < self.messages

    def keep_only(self, states: Iterable[Told]) -> None:
        assert all(isinstance(state, Told) for state in states)

    def faults(self, state: Told) -> Iterator[Fault]:
        assert self.is_open(state)
        yield Fault("lost")
        yield Fault("twice")

    def strike(self, state: Told, fault: Fault) -> Told:
        return self._done(state, fault.kind)

    def say(self, state: Told) -> str:
        return f"message {state.sent}"

    def _done(self, state: Told, what: str) -> Told:
        did = (*state.did, what)
        return Told(state.sent + 1, did if self.remembers else tuple(sorted(did)))


class Pair(NamedTuple):
    step: int
    counts: tuple[int, int] = (0, 0)


class Race:
    """Two counters that are told to count in turns may differ by 2 at most. Two losses make it 3."""

    def start(self) -> Pair:
        return Pair(0)

    def rank(self, state: Pair) -> tuple[int, ...]:
        return (state.step,)

    def follow(self, state: Pair) -> Pair | None:
        if state.step == 12:
            return None
        counts = list(state.counts)
        counts[state.step % 2] += 1
        if abs(counts[0] - counts[1]) > 2:
            raise Breach("near", f"{counts[0]} and {counts[1]}")
        return Pair(state.step + 1, (counts[0], counts[1]))

    def hurry(self, state: Pair) -> Pair | None:
        """Three steps at once."""
        after: Pair | None = state
        for _ in range(3):
            after = None if after is None else self.follow(after)
        return after

    def is_open(self, state: Pair) -> bool:
        return state.step < 6

    def keep_only(self, states: Iterable[Pair]) -> None:
        pass

    def faults(self, state: Pair) -> Iterator[Fault]:
        assert self.is_open(state)
        yield Fault("loss", state.step % 2)

    def strike(self, state: Pair, fault: Fault) -> Pair:
        del fault
        return Pair(state.step + 1, state.counts)

    def say(self, state: Pair) -> str:
        return "end" if state.step == 12 else f"count {state.step % 2}"


def always() -> bool:
    return True


def explored(messages: int, faults: int, *, remembers: bool) -> Explored:
    return Exploration(Receiver(messages, remembers), faults).run(always)


@pytest.mark.parametrize("faults", range(4))
def test_every_schedule_is_covered_exactly_once(faults: int) -> None:
    found = explored(9, faults, remembers=True)
    expected = tuple(comb(9, struck) * 2**struck for struck in range(faults + 1))
    assert (found.ended, found.schedules, found.depth) == (Ended.COMPLETE, expected, 9)


def test_states_that_schedules_share_are_expanded_once_and_all_schedules_counted() -> None:
    remembered, merged = (explored(9, 3, remembers=remembers) for remembers in (True, False))
    assert merged.schedules == remembered.schedules
    assert merged.states < remembered.states / 5
    # of n messages, `lost` were lost and `twice` came twice
    assert merged.states == sum(
        1 for n in range(10) for lost in range(4) for twice in range(4 - lost) if lost + twice <= n
    )


def test_every_transition_is_counted() -> None:
    assert explored(2, 0, remembers=True).transitions == 2
    assert explored(2, 1, remembers=True).transitions == 3 + 3 + 2  # the last two from states with a fault


def test_a_race_that_needs_two_faults_is_found_with_two_and_not_with_one() -> None:
    *clean, breach = deepen(Race(), 3, always)
    assert [(found.faults, found.ended) for found in clean] == [(0, Ended.COMPLETE), (1, Ended.COMPLETE)]
    assert (breach.faults, breach.ended) == (2, Ended.BREACH)
    assert breach.broken is not None
    assert breach.broken.promise == "near"
    assert len(breach.broken.strikes) == 2


def test_the_faults_of_a_breach_lead_to_it_again() -> None:
    *_, breach = deepen(Race(), 3, always)
    assert breach.broken is not None
    steps = retell(Race(), breach.broken.strikes)
    told: list[tuple[str, Fault | None]] = []
    with pytest.raises(Breach, match=breach.broken.why):
        told.extend((said, fault) for _, said, fault in steps)
    assert [fault for _, fault in told if fault is not None] == [
        strike.fault for strike in breach.broken.strikes
    ]


def test_a_schedule_without_faults_is_told_to_its_end() -> None:
    assert [said for _, said, _ in retell(Race(), ())] == ["count 0", "count 1"] * 6 + ["end"]


def test_an_exploration_that_runs_out_of_time_says_so() -> None:
    *_, last = deepen(Receiver(9, remembers=True), 3, lambda: False)
    assert (last.faults, last.ended, last.states) == (0, Ended.TIME, 0)
