import math
from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from protocol.frames import Pose
from protocol.wire.link import LATELY_S, Link
from protocol.wire.messages import AheadState, BehindState

HERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
SILENCE_S = 1.0


def state(epoch: int, progress_m: float, *, t_s: float = 0.0, echo_s: float = 0.0) -> BehindState:
    return BehindState(
        epoch=epoch,
        t_s=t_s,
        echo_s=echo_s,
        vertices=1,
        progress_m=progress_m,
        tail_progress_m=0.0,
        stand=True,
        pose=HERE,
    )


@st.composite
def deliveries(draw: st.DrawFn) -> list[tuple[int, int]]:
    """Epochs and numbers in order of arrival: shuffled, some lost, some repeated."""
    numbers = st.tuples(st.integers(1, 3), st.integers(1, 30))
    return draw(st.lists(numbers, min_size=1, max_size=40))


def told(epoch: int, number: int) -> BehindState:
    """A state that contains its identity."""
    return state(epoch, progress_m=1000.0 * epoch + number)


def made(made_at_s: float = 0.0) -> Link[BehindState]:
    return Link(2, made_at_s)


def hear_all(link: Link[BehindState], arriving: Sequence[tuple[int, int]]) -> list[bool]:
    return [
        link.hear(told(epoch, number), number, now_s=float(now))
        for now, (epoch, number) in enumerate(arriving, start=1)
    ]


@given(deliveries())
def test_the_newest_state_is_kept_in_any_order_of_arrival(arriving: list[tuple[int, int]]) -> None:
    link = made()
    hear_all(link, arriving)
    assert link.state == told(*max(arriving))


@given(deliveries())
def test_a_state_is_new_only_if_it_is_newer_than_all_before(arriving: list[tuple[int, int]]) -> None:
    link = made()
    newer = [all(each > before for before in arriving[:at]) for at, each in enumerate(arriving)]
    assert hear_all(link, arriving) == newer


@given(deliveries())
def test_heard_at_s_is_the_time_of_the_last_new_state(arriving: list[tuple[int, int]]) -> None:
    link = made()
    news = [at for at, newer in enumerate(hear_all(link, arriving), start=1) if newer]
    assert link.heard_at_s == float(news[-1])


def test_a_state_of_a_new_epoch_is_newer_for_any_number() -> None:
    link = made()
    assert link.hear(state(1, 5.0), 900, now_s=1.0)
    assert link.hear(state(2, 1.0), 1, now_s=2.0)
    assert not link.hear(state(1, 6.0), 901, now_s=3.0)
    assert link.state == state(2, 1.0)
    assert link.heard_at_s == 2.0


# --- the lease --------------------------------------------------------------------------------------


def test_a_link_without_any_state_is_silent_since_its_creation() -> None:
    link = made(3.0)
    assert (link.state, link.established) == (None, False)
    assert link.silent_s(5.0) == 2.0


def test_silence_is_the_age_of_the_newest_echoed_time_stamp() -> None:
    link = made(3.0)
    link.hear(state(1, 0.0, t_s=3.2, echo_s=3.1), 1, now_s=3.3)
    link.hear(state(1, 0.0, t_s=3.6, echo_s=3.1), 2, now_s=3.7)
    assert link.established
    assert link.silent_s(4.0) == 4.0 - 3.1


def test_a_neighbour_that_hears_nothing_is_silent_though_its_messages_arrive() -> None:
    link = made(3.0)
    for beat in range(1, 9):
        assert link.hear(state(1, 0.0, t_s=3.0 + beat, echo_s=0.0), beat, now_s=3.0 + beat)
    assert not link.established
    assert (link.silent_s(11.0), link.heard_at_s) == (8.0, 11.0)


def test_an_echo_of_zero_at_the_start_of_a_run_is_no_echo() -> None:
    link = made(0.0)
    link.hear(state(1, 0.0, t_s=0.0, echo_s=0.0), 1, now_s=0.0)
    assert not link.established


def test_a_message_that_was_delayed_for_long_renews_nothing() -> None:
    link = made()
    link.hear(state(1, 0.0, t_s=0.5, echo_s=0.4), 1, now_s=9.0)
    assert link.silent_s(9.0) == 9.0 - 0.4


def test_an_echo_from_before_the_links_creation_renews_nothing() -> None:
    link = made(3.0)
    link.hear(state(1, 0.0, t_s=3.2, echo_s=2.9), 1, now_s=3.3)
    assert not link.established
    assert link.silent_s(3.5) == 0.5


def test_a_state_with_an_echo_from_the_future_is_ignored() -> None:
    link = made()
    assert not link.hear(state(1, 0.0, t_s=0.5, echo_s=7.0), 1, now_s=0.6)
    assert (link.state, link.established) == (None, False)


def test_an_older_echo_in_a_newer_state_does_not_age_the_link() -> None:
    link = made()
    link.hear(state(1, 0.0, t_s=1.0, echo_s=0.9), 1, now_s=1.0)
    link.hear(state(1, 0.0, t_s=0.8, echo_s=0.5), 2, now_s=1.1)
    assert (link.said_s, link.silent_s(1.9)) == (1.0, 1.9 - 0.9)


AHEAD = AheadState(
    epoch=1,
    path_from=0,
    path=(),
    progress_m=0.0,
    authority_m=0.0,
    pose=HERE,
    arrived=False,
    lineage=(),
    vertices=0,
    backs_up=False,
    reversal=None,
)

# The next event, the time since the one before, and for a delivery the message and whether it is repeated.
events = st.lists(
    st.tuples(
        st.sampled_from(["say ahead", "say behind", "to ahead", "to behind"]),
        st.sampled_from([0.0, 0.05, 0.25, 0.6, 1.5]),
        st.integers(0, 20),
        st.booleans(),
    ),
    max_size=60,
)


@given(events, st.sampled_from([-0.4, 0.0, 0.4]))
def test_a_robot_that_was_silent_for_a_lease_time_holds_no_lease(
    happening: list[tuple[str, float, int, bool]], skew_s: float
) -> None:
    """Under any loss, delay and repetition, with two clocks of equal rate and different times."""
    true_s, numbers = 10.0, iter(range(1, 999))
    behinds = Link[AheadState](1, true_s + skew_s)  # the link at the robot behind, by its clock
    aheads = made(true_s)
    last_heard_s = {"ahead": -99.0, "behind": -99.0}  # when the other end heard it, in true time
    way: dict[str, list[tuple[int, AheadState | BehindState]]] = {"ahead": [], "behind": []}
    for what, after_s, which, again in happening:
        true_s += after_s
        behind_s = true_s + skew_s
        match what.split():
            case ["say", "ahead"]:
                said = replace(AHEAD, t_s=true_s, echo_s=aheads.said_s)
                way["behind"].append((next(numbers), said))
            case ["say", "behind"]:
                said_back = state(1, 0.0, t_s=behind_s, echo_s=behinds.said_s)
                way["ahead"].append((next(numbers), said_back))
            case ["to", receiver] if way[receiver]:
                at = which % len(way[receiver])
                number, heard = way[receiver][at] if again else way[receiver].pop(at)
                if isinstance(heard, AheadState) and behinds.hear(heard, number, behind_s):
                    last_heard_s["ahead"] = true_s
                if isinstance(heard, BehindState) and aheads.hear(heard, number, true_s):
                    last_heard_s["behind"] = true_s
            case _:
                pass
        for name, link, now_s in (("ahead", aheads, true_s), ("behind", behinds, behind_s)):
            if link.established and link.silent_s(now_s) <= SILENCE_S:
                assert true_s <= last_heard_s[name] + SILENCE_S + 1e-9


def test_the_silent_share_decays_at_the_rate_at_which_it_grew() -> None:
    link, shares = made(), []
    for second in range(1, 60):
        if second > 30:
            link.hear(state(1, 0.0, echo_s=float(second)), second, now_s=float(second))
        link.note(float(second), silence_s=SILENCE_S)
        shares.append(link.silent_share)
    assert shares[0] == 0.0, "not silent yet"
    assert shares[29] == pytest.approx(1.0 - math.exp(-29.0 / LATELY_S))
    assert shares[-1] == pytest.approx(shares[29] * math.exp(-29.0 / LATELY_S))
