import math
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.fence import Epoch
from protocol.wire.link import LATELY_S, Link
from protocol.wire.messages import BehindState

SILENCE_S = 1.0
LIFE, EPOCH = 0x2B, Epoch(generation=1, robot=2, life=0x2B)


def state(
    progress_m: float = 0.0, *, t_s: float = 0.0, life: int = LIFE, epoch: Epoch = EPOCH
) -> BehindState:
    return BehindState(
        epoch=epoch,
        life=life,
        t_s=t_s,
        vertices=1,
        progress_m=progress_m,
        tail_progress_m=0.0,
        stand=True,
    )


def made(made_at_s: float = 0.0) -> Link[BehindState]:
    return Link(2, LIFE, EPOCH, made_at_s)


numbers = st.lists(st.integers(1, 30), min_size=1, max_size=40)
"""In order of arrival: shuffled, some lost, some repeated."""


def hear_all(link: Link[BehindState], arriving: Sequence[int]) -> list[bool]:
    """Hear states that each tell their number as progress and as time."""
    return [
        link.hear(state(float(number), t_s=float(number)), number, now_s=100.0 + at)
        for at, number in enumerate(arriving)
    ]


# --- rule 1 ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("robot", "said", "is_from"),
    [
        (2, state(), True),
        (3, state(), False),
        (2, state(life=LIFE + 1), False),
        (2, state(epoch=Epoch(generation=2, robot=2, life=LIFE)), False),
        (2, state(epoch=Epoch(generation=1, robot=2, life=LIFE + 1)), False),
    ],
    ids=[
        "its own",
        "of another robot",
        "of another life",
        "of another epoch",
        "of another coordinator's life",
    ],
)
def test_a_link_is_to_one_life_of_a_robot_in_one_epoch(robot: int, said: BehindState, is_from: bool) -> None:
    assert made().is_from(robot, said) is is_from


# --- rule 2 ---------------------------------------------------------------------------------------


@given(numbers)
def test_the_newest_state_is_kept_in_any_order_of_arrival(arriving: list[int]) -> None:
    link = made()
    hear_all(link, arriving)
    assert link.state == state(float(max(arriving)), t_s=float(max(arriving)))


@given(numbers)
def test_a_state_is_new_only_if_it_is_newer_than_all_before(arriving: list[int]) -> None:
    link = made()
    newer = [all(each > before for before in arriving[:at]) for at, each in enumerate(arriving)]
    assert hear_all(link, arriving) == newer


# --- rule 3 ---------------------------------------------------------------------------------------


def test_a_link_without_any_state_is_silent_since_its_creation() -> None:
    link = made(3.0)
    assert link.state is None
    assert link.silent_s(5.0) == 2.0


@given(numbers)
def test_silence_is_the_age_of_the_newest_time_stamp_heard(arriving: list[int]) -> None:
    link = made()
    hear_all(link, arriving)
    assert link.silent_s(200.0) == 200.0 - max(arriving)


def test_a_message_that_was_delayed_for_long_renews_nothing() -> None:
    link = made()
    link.hear(state(t_s=0.5), 1, now_s=9.0)
    assert link.silent_s(9.0) == 8.5


def test_a_state_from_before_the_links_creation_renews_nothing() -> None:
    link = made(3.0)
    link.hear(state(t_s=2.9), 1, now_s=3.3)
    assert link.silent_s(3.5) == 0.5


def test_a_time_stamp_from_the_future_counts_as_the_time_of_its_arrival() -> None:
    link = made()
    assert link.hear(state(t_s=9e6), 1, now_s=0.6)
    assert link.heard_at_s == 0.6
    assert link.silent_s(2.6) == 2.0


def test_an_older_time_stamp_in_a_newer_state_does_not_age_the_link() -> None:
    link = made()
    link.hear(state(t_s=1.0), 1, now_s=1.0)
    link.hear(state(5.0, t_s=0.8), 2, now_s=1.1)
    assert (link.state, link.heard_at_s) == (state(5.0, t_s=0.8), 1.0)


def test_the_usual_time_between_two_states_follows_the_newest_ones() -> None:
    link = made()
    for second in range(1, 40):
        link.hear(state(t_s=float(second)), second, now_s=float(second))
    assert link.usual_s == pytest.approx(1.0, abs=1e-3)


# --- rule 4 ---------------------------------------------------------------------------------------


def test_a_link_says_once_that_it_has_fallen_silent_and_once_that_it_is_heard_again() -> None:
    link = made()
    link.hear(state(t_s=1.0), 1, now_s=1.0)
    assert [link.note(at_s, silence_s=SILENCE_S) for at_s in (1.5, 2.0, 2.1, 3.0)] == [
        False,
        False,
        True,
        False,
    ]
    link.hear(state(t_s=3.1), 2, now_s=3.1)
    assert [link.note(at_s, silence_s=SILENCE_S) for at_s in (3.1, 3.2)] == [True, False]


def test_the_silent_share_decays_at_the_rate_at_which_it_grew() -> None:
    link, shares = made(), []
    for second in range(1, 60):
        if second > 30:
            link.hear(state(t_s=float(second)), second, now_s=float(second))
        link.note(float(second), silence_s=SILENCE_S)
        shares.append(link.silent_share)
    assert shares[0] == 0.0, "not silent yet"
    assert shares[29] == pytest.approx(1.0 - math.exp(-29.0 / LATELY_S))
    assert shares[-1] == pytest.approx(shares[29] * math.exp(-29.0 / LATELY_S))
