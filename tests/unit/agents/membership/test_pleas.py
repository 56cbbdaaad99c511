"""How a leader lets robots in that are left out."""

import pytest

from agents.liveness.timing import Timing
from agents.membership.pleas import STOP_S, Pleas
from protocol.fence import Cause

TIMING = Timing()


def test_a_leader_lets_a_robot_in_at_its_next_stop_or_after_a_while() -> None:
    pleas = Pleas(TIMING)
    assert pleas.reason(9.0, stands=True) is None
    _hear(pleas, 3, 10.0)
    assert pleas.reason(10.0 + STOP_S, stands=False) is None
    for reason in (pleas.reason(10.0, stands=True), pleas.reason(10.1 + STOP_S, stands=False)):
        assert reason is not None
        assert (reason.cause, reason.about) == (Cause.PLEA, 3)


def test_the_first_that_asks_is_the_one_that_the_view_is_about() -> None:
    pleas = Pleas(TIMING)
    _hear(pleas, 3, 10.0)
    _hear(pleas, 4, 11.0)
    assert pleas.asking == [3, 4]
    reason = pleas.reason(12.0, stands=True)
    assert reason is not None
    assert reason.about == 3


def test_a_new_view_forgets_who_has_asked() -> None:
    pleas = Pleas(TIMING)
    _hear(pleas, 3, 10.0)
    pleas.forget()
    assert pleas.reason(20.0, stands=True) is None


def test_the_same_robot_is_let_in_again_after_a_time_that_doubles_to_a_limit() -> None:
    pleas, now_s, waited = Pleas(TIMING), 0.0, []
    _hear(pleas, 3, now_s)
    for _ in range(8):
        pleas.let_in([3], now_s)
        pleas.forget()
        wait_s = next(step / 2 for step in range(1000) if _asks(pleas, 3, now_s + step / 2))
        waited.append(wait_s)
        now_s += wait_s
    first_s, most_s = TIMING.plea_again_s, TIMING.plea_again_s_max
    assert waited == [min(first_s * 2.0**times, most_s) for times in range(8)]
    assert waited[-1] == most_s


def test_the_times_when_the_leader_has_arrived_count_apart() -> None:
    pleas = Pleas(TIMING)
    for _ in range(5):
        _hear(pleas, 3, 0.0)
        pleas.let_in([3], 100.0)
        pleas.forget()
    assert not _asks(pleas, 3, 101.0)
    _hear(pleas, 3, 101.0, arrived=True)
    assert pleas.asking == [3]
    pleas.let_in([3], 101.0)
    pleas.forget()
    _hear(pleas, 3, 100.9 + TIMING.plea_again_s, arrived=True)
    assert pleas.asking == []
    _hear(pleas, 3, 101.0 + TIMING.plea_again_s, arrived=True)
    assert pleas.asking == [3]


def test_a_view_that_was_proposed_for_a_robot_and_finds_no_way_for_it_counts_once() -> None:
    pleas = Pleas(TIMING)
    pleas.let_in([3], 0.0)
    pleas.let_in([3], 0.5 * TIMING.plea_again_s)
    assert _asks(pleas, 3, TIMING.plea_again_s)


def test_a_robot_that_was_let_in_often_keeps_no_other_waiting() -> None:
    pleas = Pleas(TIMING)
    _hear(pleas, 3, 0.0)
    for _ in range(5):
        pleas.let_in([3], 0.0)
    pleas.forget()
    _hear(pleas, 3, 1.0)
    assert pleas.reason(1.0, stands=True) is None
    _hear(pleas, 4, 1.0)
    assert pleas.reason(1.0, stands=True) is not None


def test_a_robot_for_which_the_leader_found_no_way_is_let_in_when_a_body_has_moved() -> None:
    pleas = Pleas(TIMING)
    pleas.note_stranded([3], 10.0)
    pleas.hear(3, 20.0, stood_s=10.0, arrived=False, may_lead=False)
    assert pleas.asking == [], "nothing has changed"
    pleas.hear(4, 20.0, stood_s=10.0, arrived=False, may_lead=False)
    assert pleas.asking == [4], "it was not there"
    pleas.hear(3, 21.0, stood_s=0.5, arrived=False, may_lead=False)
    assert pleas.asking == [4, 3]


@pytest.mark.parametrize("why", ["arrived", "may_lead"])
def test_a_stranded_robot_is_let_in_sooner_by_a_leader_that_has_arrived_or_lets_it_lead(why: str) -> None:
    pleas = Pleas(TIMING)
    pleas.note_stranded([3], 0.0)
    pleas.hear(3, 9.0, stood_s=9.0, **{"arrived": False, "may_lead": False, why: True})
    assert pleas.asking == [3]


def _hear(pleas: Pleas, robot: int, now_s: float, *, arrived: bool = False) -> None:
    """While bodies move."""
    pleas.hear(robot, now_s, stood_s=0.0, arrived=arrived, may_lead=False)


def _asks(pleas: Pleas, robot: int, now_s: float) -> bool:
    _hear(pleas, robot, now_s)
    return pleas.reason(now_s, stands=True) is not None
