"""One end of a link: what is taken from it, and how long it has been silent."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.fence import Epoch
from protocol.wire.link import Link
from protocol.wire.messages import BehindState

SILENCE_S = 1.0
EPOCH = Epoch(generation=4, robot=1, life=71)
LIFE = 72


def state(
    progress_m: float = 0.0, *, t_s: float = 0.0, epoch: Epoch = EPOCH, life: int = LIFE
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


@given(numbers)
def test_the_newest_state_is_kept_in_any_order_of_arrival(arriving: list[int]) -> None:
    link = made()
    newer = [link.hear(state(float(number)), number, now_s=0.0) for number in arriving]
    assert link.state == state(float(max(arriving)))
    assert newer == [all(each > before for before in arriving[:at]) for at, each in enumerate(arriving)]


@pytest.mark.parametrize(
    ("robot", "said", "valid"),
    [
        (2, state(), True),
        (3, state(), False),
        (2, state(life=LIFE + 1), False),
        (2, state(epoch=Epoch(generation=5, robot=1, life=71)), False),
        (2, state(epoch=Epoch(generation=4, robot=2, life=71)), False),
        (2, state(epoch=Epoch(generation=4, robot=1, life=70)), False),
    ],
)
def test_a_link_is_to_one_life_of_one_robot_in_one_epoch(
    robot: int, said: BehindState, *, valid: bool
) -> None:
    assert made().is_from(robot, said) is valid


def test_a_link_without_any_state_is_silent_since_its_creation() -> None:
    assert made(3.0).silent_s(5.0) == 2.0


@given(st.lists(st.tuples(st.integers(1, 30), st.floats(0.0, 9.0)), max_size=20), st.floats(0.0, 9.0))
def test_silence_is_the_age_of_the_newest_time_stamp_heard(
    arriving: list[tuple[int, float]], now_s: float
) -> None:
    link, newest, heard_s = made(), 0, 0.0
    for number, t_s in arriving:
        if link.hear(state(t_s=t_s), number, now_s):
            assert number > newest
            newest, heard_s = number, max(heard_s, min(t_s, now_s))
    assert link.silent_s(now_s) == pytest.approx(now_s - heard_s)


def test_a_message_that_was_delayed_for_long_renews_nothing() -> None:
    link = made()
    link.hear(state(t_s=0.4), 1, now_s=9.0)
    assert link.silent_s(9.0) == pytest.approx(8.6)


def test_a_time_stamp_ahead_of_the_own_time_counts_as_now() -> None:
    link = made()
    link.hear(state(t_s=99.0), 1, now_s=2.0)
    assert link.silent_s(5.0) == 3.0


def test_each_silence_and_its_end_are_noted_once() -> None:
    link, noted = made(), []
    for number, (t_s, heard) in enumerate(
        [(0.5, True), (1.0, False), (1.6, False), (3.0, False), (3.1, True), (3.2, True)], start=1
    ):
        if heard:
            link.hear(state(t_s=t_s), number, now_s=t_s)
        noted.append((link.note(t_s, silence_s=SILENCE_S), link.silent))
    changed, last = (True, True), (True, False)
    assert noted == [(False, False), (False, False), changed, (False, True), last, (False, False)]
