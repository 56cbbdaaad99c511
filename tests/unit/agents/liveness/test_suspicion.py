"""Whom a robot holds for lost, and whom it leaves out for a while."""

from hypothesis import given
from hypothesis import strategies as st

from agents.liveness.suspicion import HALF_LIFE_S, SUPPRESS, Suspicion
from agents.liveness.timing import Timing
from protocol.fence import Epoch
from protocol.wire.link import Link
from protocol.wire.messages import BehindState

TIMING = Timing()
SILENT_S = TIMING.silent_s
EPOCH = Epoch(generation=1, robot=1, life=7)


def awake(*robots: int, until_s: float = 10.0) -> Suspicion:
    """A robot that has had odometry ten times a second, and sees these tokens and the world's."""
    suspicion = Suspicion(TIMING)
    for robot in (0, *robots):
        suspicion.presence.come(robot, "a", 0.0)
    for tenth in range(round(10 * until_s) + 1):
        suspicion.live(tenth / 10)
    return suspicion


def heard(at_s: float) -> Link[BehindState]:
    """A link to robot 2 that was heard last at that time."""
    link: Link[BehindState] = Link(2, 9, EPOCH, 0.0)
    link.heard_at_s = at_s
    return link


# --- lost neighbours --------------------------------------------------------------------------------


def test_a_neighbour_whose_token_has_gone_is_lost_at_once_and_a_silent_one_later() -> None:
    suspicion = awake(2)
    assert suspicion.why_lost(heard(9.9), 10.0) is None
    assert suspicion.why_lost(heard(10.0 - SILENT_S - 0.1), 10.0) == "silence"
    suspicion.presence.go(2, "a", 9.0)
    assert suspicion.why_lost(heard(9.0), 10.0) == "token"


def test_a_neighbour_that_was_started_again_between_the_formation_and_its_all_is_lost_by_its_token() -> None:
    suspicion = awake(2, until_s=9.0)
    suspicion.presence.go(2, "a", 9.0)
    suspicion.presence.come(2, "b", 9.1)
    suspicion.live(9.7)
    link: Link[BehindState] = Link(2, 9, EPOCH, 9.2)
    assert suspicion.why_lost(link, 9.7, named_s=8.9) == "token"
    assert suspicion.why_lost(link, 9.7, named_s=9.1) is None, "the formation may name the new life"
    link.heard_at_s = 9.6
    assert suspicion.why_lost(link, 9.7, named_s=8.9) is None


def test_where_all_wait_a_neighbour_that_is_silent_is_lost_however_seldom_it_is_heard() -> None:
    link = heard(10.0 - 1.5)
    assert awake(2).why_lost(link, 10.0, all_wait=True) is None
    link.silent = True
    assert awake(2).why_lost(link, 10.0) is None
    assert awake(2).why_lost(link, 10.0, all_wait=True) == "silence"


def test_a_robot_that_has_had_a_gap_of_its_own_judges_nobody_until_it_has_listened() -> None:
    suspicion = awake(2)
    back_s = 10.0 + TIMING.gap_s + 0.1
    suspicion.presence.go(2, "a", 10.0)
    suspicion.live(back_s)
    for late_s in (0.0, TIMING.listens_s - 0.01):
        assert not suspicion.judges(back_s + late_s)
        assert suspicion.why_lost(heard(0.0), back_s + late_s) is None
        assert not suspicion.has_gone(2, 0.0, back_s + late_s)
    assert suspicion.why_lost(heard(0.0), back_s + TIMING.listens_s) == "token"


def test_a_gap_that_is_no_longer_than_may_be_is_none() -> None:
    suspicion = awake(2)
    suspicion.live(10.0 + TIMING.gap_s - 0.01)
    assert suspicion.judges(10.0 + TIMING.gap_s)


def test_a_robot_that_does_not_see_the_world_judges_nobody() -> None:
    suspicion = awake(2)
    suspicion.presence.go(0, "a", 9.0)
    suspicion.presence.go(2, "a", 9.0)
    assert suspicion.why_lost(heard(0.0), 10.0) is None


# --- penalties --------------------------------------------------------------------------------------


def test_a_robot_that_is_lost_is_left_out_for_a_while_and_for_longer_when_lost_again() -> None:
    once, again = awake(2), awake(2)
    once.blame(2, 0.0)
    again.blame(2, 0.0)
    again.blame(2, 1.0)
    assert once.suppressed(0.0) == again.suppressed(1.0) == {2}
    assert once.suppressed(HALF_LIFE_S / 2.0) == frozenset()
    assert again.suppressed(1.0 + HALF_LIFE_S) == {2}
    assert again.suppressed(1.0 + 2.0 * HALF_LIFE_S) == frozenset()


def test_one_that_keeps_the_others_waiting_is_left_out_at_once() -> None:
    suspicion = awake(2)
    suspicion.blame(2, 0.0, penalty=2.0)
    assert suspicion.suppressed(0.0) == {2}


@given(st.lists(st.floats(0.0, 120.0), min_size=1, max_size=6), st.floats(0.0, 300.0))
def test_a_penalty_halves_with_each_half_life_and_counts_above_its_limit(
    at_s: list[float], later_s: float
) -> None:
    suspicion, value, last_s = awake(2), 0.0, 0.0
    for now_s in sorted(at_s):
        value = 1.0 + value * 0.5 ** ((now_s - last_s) / HALF_LIFE_S)
        last_s = now_s
        suspicion.blame(2, now_s)
    now_s = last_s + later_s
    left = value * 0.5 ** (later_s / HALF_LIFE_S)
    if abs(left - SUPPRESS) > 1e-6:
        assert (2 in suspicion.suppressed(now_s)) == (left > SUPPRESS)
