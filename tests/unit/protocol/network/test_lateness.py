"""How late a process runs: what counts as lateness of the machine, and for how long."""

import pytest

from protocol.network.lateness import HALF_LIFE_S, Lateness
from protocol.wire.messages import LATE_S_MAX


def late(*turns: tuple[float, float]) -> Lateness:
    """A process whose turns begin at these times, by the wall clock and by its CPU; each asks for 0.1 s."""
    lateness = Lateness()
    for wall_s, cpu_s in turns:
        lateness.turn(wall_s, cpu_s, asked_s=0.1)
    return lateness


def test_a_turn_that_was_only_as_long_as_asked_is_not_late() -> None:
    assert late((5.0, 1.0), (5.1, 1.0), (5.15, 1.0)).now_s(5.15) == 0.0


def test_a_turn_is_late_by_the_time_in_which_it_neither_computed_nor_was_to_wait() -> None:
    assert late((5.0, 1.0), (5.5, 1.1)).now_s(5.5) == pytest.approx(0.3)


def test_a_turn_is_measured_by_the_wait_that_it_was_asked_for_and_not_by_that_of_the_next() -> None:
    lateness = Lateness()
    lateness.turn(5.0, 1.0, asked_s=0.1)  # nothing is due for 0.1 s
    lateness.turn(5.1, 1.0, asked_s=0.0)  # now something is
    assert lateness.now_s(5.1) == pytest.approx(0.0)
    lateness.turn(5.3, 1.0, asked_s=0.2)
    assert lateness.now_s(5.3) == pytest.approx(0.2)


def test_a_long_computation_is_no_lateness() -> None:
    assert late((5.0, 1.0), (7.0, 2.95)).now_s(7.0) == 0.0


def test_a_process_that_was_stopped_says_nothing_about_the_machine() -> None:
    assert late((5.0, 1.0), (5.0 + LATE_S_MAX + 0.2, 1.0)).now_s(9.0) == 0.0


def test_the_longest_delay_lately_counts_and_is_halved_with_time() -> None:
    lateness = Lateness()
    lateness.hear(0.4, 10.0)
    lateness.hear(0.1, 10.0)
    assert lateness.now_s(10.0) == 0.4
    assert lateness.now_s(10.0 + HALF_LIFE_S) == pytest.approx(0.2)
    lateness.hear(0.3, 10.0 + HALF_LIFE_S)
    assert lateness.now_s(10.0 + HALF_LIFE_S) == 0.3
