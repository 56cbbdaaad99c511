"""Whom a robot calls in that asks to join, and whom it does not hear for a while."""

import pytest
from agents.membership.calls import BREAKS_MAX, BREAKS_S, FAILED_TURNS, INVITES_S, INVITES_S_MAX, SHUNNED_S

from protocol.keys import WORLD_NUMBER
from tests.support.stages.calls_stage import calls


def test_who_asks_again_and_again_is_called_in_after_twice_the_time_each_time_up_to_a_limit() -> None:
    made = calls(2)
    tenths = range(round(10.0 * (15.0 * INVITES_S + 2.5 * INVITES_S_MAX)))
    called_s = [tenth / 10.0 for tenth in tenths if made.invites(2, tenth / 10.0)]
    doubled_s = [0.0, INVITES_S, 3.0 * INVITES_S, 7.0 * INVITES_S, 15.0 * INVITES_S]
    assert called_s == [*doubled_s, doubled_s[-1] + INVITES_S_MAX, doubled_s[-1] + 2.0 * INVITES_S_MAX]


def test_one_that_keeps_failing_does_not_keep_another_from_being_called_in() -> None:
    made = calls(2, 3)
    assert [made.invites(robot, 0.0) for robot in (2, 2, 3)] == [True, False, True]


def test_who_shows_no_token_is_not_called_in() -> None:
    assert not calls(2).invites(3, 0.0)


def test_a_robot_with_which_links_keep_falling_silent_is_shunned_for_a_while_and_then_for_twice_as_long() -> (
    None
):
    made = calls(2, 3)
    lasts_s = []
    for began_s in (0.0, 100.0):
        for at_s in range(BREAKS_MAX):
            assert made.shunned(began_s + at_s) == frozenset()
            made.broke(2, began_s + at_s, since_s=0.0)
        shunned_s = [tenth for tenth in range(1000) if made.shunned(began_s + at_s + tenth / 10.0) == {2}]
        assert shunned_s[0] == 0
        lasts_s.append(len(shunned_s) / 10.0)
    assert lasts_s == [SHUNNED_S, 2.0 * SHUNNED_S]


def test_links_that_fall_silent_now_and_then_are_no_reason_to_shun_anybody() -> None:
    made = calls(2, 3)
    for at_s in (0.0, BREAKS_S, 2.0 * BREAKS_S):
        made.broke(2, at_s, since_s=0.0)
    assert made.shunned(2.0 * BREAKS_S) == frozenset()
    made.broke(2, 3.0 * BREAKS_S - 0.1, since_s=0.0)
    assert made.shunned(3.0 * BREAKS_S) == {2}


def test_who_is_shunned_is_called_in_when_it_is_heard_again_and_not_before() -> None:
    made = calls(2, 3)
    for at_s in range(BREAKS_MAX):
        made.broke(2, float(at_s), since_s=0.0)
    until_s = BREAKS_MAX - 1.0 + SHUNNED_S
    assert [made.invites(2, now_s) for now_s in (until_s - 0.1, until_s)] == [False, True]


def test_who_is_shunned_is_heard_again_where_no_way_is_found_without_it() -> None:
    made = calls(2, 3, 4)
    for robot in (2, 3):
        for at_s in range(BREAKS_MAX):
            made.broke(robot, float(at_s), since_s=0.0)
    made.forgive((1, 3, 4))
    assert made.shunned(BREAKS_MAX) == {3}, "who lines up with this robot is shunned for what it did"


def test_without_whom_no_way_is_found_is_not_shunned_for_what_it_did_before_that() -> None:
    made = calls(2, 3)
    for at_s in range(BREAKS_MAX):
        made.broke(2, float(at_s), since_s=0.0)
    made.forgive((1, 3))
    made.broke(2, float(BREAKS_MAX), since_s=0.0)
    assert made.shunned(BREAKS_MAX) == frozenset()
    made.broke(2, BREAKS_MAX + 1.0, since_s=0.0)
    assert made.shunned(BREAKS_MAX + 1.0) == {2}


@pytest.mark.parametrize("away", [2, WORLD_NUMBER])
def test_who_was_cut_off_while_a_link_was_silent_is_not_shunned_for_that(away: int) -> None:
    made = calls(2, 3)
    made.presence.go(away, "a", 1.0)
    made.presence.come(away, "a", 5.0)
    for at_s in (5.1, 5.2):
        made.broke(2, at_s, since_s=0.5)
    assert made.shunned(5.2) == frozenset()


def test_who_was_there_and_did_not_do_is_called_in_again_only_after_a_while() -> None:
    made = calls(2, 3, 4)
    made.free_at_s((1, 2, 3), 10.0)
    made.presence.come(5, "a", 10.5)
    again_s = 10.0 + INVITES_S * 2.0**FAILED_TURNS
    assert [made.invites(4, now_s) for now_s in (10.5, again_s - 0.1, again_s)] == [False, False, True]
    assert made.invites(5, 10.5), "it had gone, and has just come back"
