from collections.abc import Sequence

from hypothesis import given
from hypothesis import strategies as st

from protocol.frames import Pose
from protocol.link import Link
from protocol.messages import BehindState

HERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)


def state(epoch: int, progress_m: float) -> BehindState:
    return BehindState(
        epoch=epoch, vertices=1, progress_m=progress_m, tail_progress_m=0.0, stand=True, pose=HERE
    )


@st.composite
def deliveries(draw: st.DrawFn) -> list[tuple[int, int]]:
    """Epochs and numbers as they come: in any order, some lost, some more than once."""
    numbers = st.tuples(st.integers(1, 3), st.integers(1, 30))
    return draw(st.lists(numbers, min_size=1, max_size=40))


def told(epoch: int, number: int) -> BehindState:
    """A state that shows which one it is."""
    return state(epoch, progress_m=1000.0 * epoch + number)


def hear_all(link: Link[BehindState], arriving: Sequence[tuple[int, int]]) -> list[bool]:
    return [
        link.hear(told(epoch, number), number, now_s=float(now))
        for now, (epoch, number) in enumerate(arriving, start=1)
    ]


@given(deliveries())
def test_however_states_come_the_newest_is_kept(arriving: list[tuple[int, int]]) -> None:
    link = Link[BehindState](neighbour=2, heard_at_s=0.0)
    hear_all(link, arriving)
    assert link.state == told(*max(arriving))


@given(deliveries())
def test_a_state_is_news_only_if_it_is_newer_than_all_before_it(arriving: list[tuple[int, int]]) -> None:
    link = Link[BehindState](neighbour=2, heard_at_s=0.0)
    newer = [all(each > before for before in arriving[:at]) for at, each in enumerate(arriving)]
    assert hear_all(link, arriving) == newer


@given(deliveries(), st.floats(0.0, 10.0))
def test_silence_is_the_time_since_the_last_news(arriving: list[tuple[int, int]], later_s: float) -> None:
    link = Link[BehindState](neighbour=2, heard_at_s=0.0)
    news = [at for at, newer in enumerate(hear_all(link, arriving), start=1) if newer]
    assert link.silent_s(news[-1] + later_s) == news[-1] + later_s - news[-1]


def test_a_link_that_never_heard_anything_is_silent_since_it_was_made() -> None:
    link = Link[BehindState](neighbour=2, heard_at_s=3.0)
    assert link.state is None
    assert link.silent_s(5.0) == 2.0


def test_a_new_epoch_is_newer_whatever_its_numbers() -> None:
    link = Link[BehindState](neighbour=2, heard_at_s=0.0)
    assert link.hear(state(1, 5.0), 900, now_s=1.0)
    assert link.hear(state(2, 1.0), 1, now_s=2.0)
    assert not link.hear(state(1, 6.0), 901, now_s=3.0)
    assert link.state == state(2, 1.0)
    assert link.heard_at_s == 2.0
