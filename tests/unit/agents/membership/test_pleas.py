"""How a leader lets robots in that are left out."""

from agents.liveness.timing import Timing
from agents.membership.pleas import STOP_S, Pleas
from protocol.fence import Cause

TIMING = Timing()


def test_a_leader_lets_a_robot_in_at_its_next_stop_or_after_a_while() -> None:
    pleas = Pleas(TIMING)
    assert pleas.reason(9.0, stands=True) is None
    pleas.hear(3, 10.0, stranded=False, arrived=False)
    assert pleas.reason(10.0 + STOP_S, stands=False) is None
    for reason in (pleas.reason(10.0, stands=True), pleas.reason(10.1 + STOP_S, stands=False)):
        assert reason is not None
        assert (reason.cause, reason.about) == (Cause.PLEA, 3)


def test_the_first_that_asks_is_the_one_that_the_view_is_about() -> None:
    pleas = Pleas(TIMING)
    pleas.hear(3, 10.0, stranded=False, arrived=False)
    pleas.hear(4, 11.0, stranded=False, arrived=False)
    assert pleas.asking == [3, 4]
    reason = pleas.reason(12.0, stands=True)
    assert reason is not None
    assert reason.about == 3


def test_a_new_view_forgets_who_has_asked() -> None:
    pleas = Pleas(TIMING)
    pleas.hear(3, 10.0, stranded=False, arrived=False)
    pleas.forget()
    assert pleas.reason(20.0, stands=True) is None


def test_the_same_robot_is_let_in_again_after_a_time_that_doubles_to_a_limit() -> None:
    pleas, now_s, waited = Pleas(TIMING), 0.0, []
    pleas.hear(3, now_s, stranded=False, arrived=False)
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
        pleas.hear(3, 0.0, stranded=False, arrived=False)
        pleas.let_in([3], 100.0)
        pleas.forget()
    assert not _asks(pleas, 3, 101.0)
    pleas.hear(3, 101.0, stranded=False, arrived=True)
    assert pleas.asking == [3]
    pleas.let_in([3], 101.0)
    pleas.forget()
    pleas.hear(3, 100.9 + TIMING.plea_again_s, stranded=False, arrived=True)
    assert pleas.asking == []
    pleas.hear(3, 101.0 + TIMING.plea_again_s, stranded=False, arrived=True)
    assert pleas.asking == [3]


def test_a_view_that_was_proposed_for_a_robot_and_finds_no_way_for_it_counts_once() -> None:
    pleas = Pleas(TIMING)
    pleas.let_in([3], 0.0)
    pleas.let_in([3], 0.5 * TIMING.plea_again_s)
    assert _asks(pleas, 3, TIMING.plea_again_s)


def test_a_robot_that_was_let_in_often_keeps_no_other_waiting() -> None:
    pleas = Pleas(TIMING)
    pleas.hear(3, 0.0, stranded=False, arrived=False)
    for _ in range(5):
        pleas.let_in([3], 0.0)
    pleas.forget()
    pleas.hear(3, 1.0, stranded=False, arrived=False)
    assert pleas.reason(1.0, stands=True) is None
    pleas.hear(4, 1.0, stranded=False, arrived=False)
    assert pleas.reason(1.0, stands=True) is not None


def _asks(pleas: Pleas, robot: int, now_s: float) -> bool:
    pleas.hear(robot, now_s, stranded=False, arrived=False)
    return pleas.reason(now_s, stands=True) is not None


def test_a_stranded_robot_is_let_in_only_by_a_leader_that_has_arrived() -> None:
    pleas = Pleas(TIMING)
    pleas.hear(3, 0.0, stranded=True, arrived=False)
    assert pleas.reason(1.0, stands=True) is None
    pleas.hear(3, 1.0, stranded=True, arrived=True)
    assert pleas.reason(1.0, stands=True) is not None


def test_a_robot_is_stranded_in_later_views_until_a_body_has_moved() -> None:
    pleas = Pleas(TIMING)
    assert not pleas.note_stranded(9.0, told_s=None, stood_s=9.0), "nobody has looked for a way yet"
    assert pleas.note_stranded(10.0, told_s=10.0, stood_s=0.0)
    assert pleas.note_stranded(30.0, told_s=None, stood_s=20.0)
    assert not pleas.note_stranded(31.0, told_s=None, stood_s=5.0), "a body has moved"


def test_in_the_view_in_which_it_was_told_so_a_robot_is_stranded_until_a_body_has_moved() -> None:
    pleas = Pleas(TIMING)
    assert pleas.note_stranded(10.0, told_s=10.0, stood_s=0.0)
    assert pleas.note_stranded(20.0, told_s=10.0, stood_s=10.0)
    assert not pleas.note_stranded(21.0, told_s=10.0, stood_s=0.5)
