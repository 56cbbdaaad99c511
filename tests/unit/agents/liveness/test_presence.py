"""Tokens as a conversation: what one robot sees of the others, and what it takes from that."""

import pytest

from agents.liveness.presence import GRACE_S, Presence
from protocol.keys import WORLD_NUMBER


def connected(*robots: int) -> Presence:
    """The world's token and those of some robots have come."""
    presence = Presence()
    for robot in (WORLD_NUMBER, *robots):
        presence.come(robot, "a", 0.0)
    return presence


def there(presence: Presence, now_s: float) -> set[int]:
    """The robots that show a token, or have just shown one."""
    return {robot for robot in (1, 2, 3) if not presence.has_gone_by(robot, now_s - GRACE_S)}


def test_a_robot_that_does_not_see_the_worlds_token_is_not_connected() -> None:
    presence = Presence()
    presence.come(1, "a", 0.0)
    seen = [presence.connected]
    presence.come(WORLD_NUMBER, "a", 0.1)
    seen.append(presence.connected)
    presence.go(WORLD_NUMBER, "a", 0.2)
    seen.append(presence.connected)
    presence.come(WORLD_NUMBER, "b", 0.3)
    seen.append(presence.connected)
    assert seen == [False, True, False, True]


def test_a_token_that_went_is_shown_no_more_and_one_that_never_came_may_go() -> None:
    presence = connected(1, 2)
    presence.go(1, "a", 5.0)
    presence.go(3, "a", 5.0)
    assert (there(presence, 6.0), presence.shows(1), presence.shows(2)) == ({2}, False, True)


def test_a_robot_is_there_while_its_token_may_come_back() -> None:
    presence, late_s = connected(1, 2), 5.0 + GRACE_S
    presence.go(1, "a", 5.0)
    assert [there(presence, now_s) for now_s in (5.0, late_s - 0.01, late_s)] == [{1, 2}, {1, 2}, {2}]


def test_a_robot_is_lost_when_its_token_has_gone_and_it_is_heard_no_more() -> None:
    presence = connected(1)
    presence.go(1, "a", 5.0)
    late_s = 5.0 + GRACE_S
    assert [presence.is_lost(1, 4.0, now_s) for now_s in (5.0, late_s - 0.01, late_s)] == [False, False, True]


def test_a_robot_heard_at_the_very_odometry_at_which_another_process_took_its_place_is_lost() -> None:
    presence = connected(1)
    presence.go(1, "a", 5.0)
    presence.come(1, "b", 5.1)
    assert presence.is_lost(1, 5.0, 5.0 + GRACE_S)
    assert not presence.is_lost(1, 5.1, 5.0 + GRACE_S), "it is the new one that was heard"


def test_a_robot_that_was_cut_off_itself_waits_for_the_tokens_of_the_others_to_come_back() -> None:
    presence = connected(1, 2)
    for robot in (1, 2, WORLD_NUMBER):
        presence.go(robot, "a", 5.0)
    presence.come(WORLD_NUMBER, "a", 6.0)
    assert not presence.is_lost(1, 4.9, 6.0), "its token is on the way"
    presence.come(1, "a", 6.0)
    assert [presence.is_lost(robot, 4.9, 6.0 + GRACE_S) for robot in (1, 2)] == [False, True]


def test_that_the_world_came_back_says_nothing_of_a_process_that_was_replaced_before() -> None:
    presence = connected(1)
    presence.come(1, "b", 5.0)
    presence.go(WORLD_NUMBER, "a", 6.0)
    presence.come(WORLD_NUMBER, "a", 7.0)
    assert not presence.is_lost(1, 6.5, 7.0 + GRACE_S)


def test_a_robot_that_has_gone_by_some_time_shows_no_token_and_has_shown_none_since() -> None:
    presence = Presence()
    presence.come(2, "a", 1.0)
    before = presence.has_gone_by(2, 9.0)
    presence.go(2, "a", 5.0)
    gone = [presence.has_gone_by(2, at_s) for at_s in (4.9, 5.0)]
    presence.come(2, "b", 8.0)
    assert [before, *gone, presence.has_gone_by(2, 9.0)] == [False, False, True, False]
    assert presence.has_gone_by(3, 9.0), "it has never come"


def test_a_robot_that_is_heard_without_a_token_is_lost_only_when_that_ends() -> None:
    presence = connected(1)
    presence.go(1, "a", 5.0)
    lost = [presence.is_lost(1, heard_at_s, 6.0) for heard_at_s in (6.0, 6.1 - GRACE_S, 6.0 - GRACE_S)]
    assert lost == [False, False, True]


def test_a_token_that_comes_back_ends_nothing() -> None:
    presence = connected(1)
    presence.go(1, "a", 5.0)
    presence.come(1, "a", 5.2)
    assert not presence.is_lost(1, 4.0, 99.0)


@pytest.mark.parametrize("old_goes_first", [True, False])
def test_a_robot_that_was_started_again_is_lost_to_who_has_not_heard_it_since(old_goes_first: bool) -> None:
    presence = connected(1)
    if old_goes_first:
        presence.go(1, "a", 4.9)
    presence.come(1, "b", 5.0)
    if not old_goes_first:
        presence.go(1, "a", 5.1)
    assert presence.shows(1), "the process that is gone must not take the other's token along"
    assert presence.is_lost(1, 4.5, 5.1 + GRACE_S)
    assert not presence.is_lost(1, 5.2, 99.0), "who is heard of after that lives on"


def test_a_robot_that_was_started_again_is_no_more_lost_than_any_other_when_its_token_is_shown_anew() -> None:
    presence = connected(1)
    presence.come(1, "b", 5.0)
    presence.go(1, "a", 5.0)
    presence.go(1, "b", 8.0)
    presence.come(1, "b", 8.01)
    assert not presence.is_lost(1, 7.9, 99.0)


def test_a_robot_that_is_cut_off_holds_nobody_for_lost() -> None:
    presence = connected(1)
    presence.go(1, "a", 5.0)
    presence.go(WORLD_NUMBER, "a", 5.0)
    assert not presence.is_lost(1, 4.0, 99.0)
    presence.come(WORLD_NUMBER, "a", 100.0)
    assert [presence.is_lost(1, 4.0, now_s) for now_s in (100.0, 100.0 + GRACE_S)] == [False, True]


def test_a_robot_whose_token_never_came_is_not_lost() -> None:
    assert not connected(1).is_lost(2, 0.0, 99.0)


def test_many_tokens_tell_the_same_as_one_by_one() -> None:
    at_once, one_by_one = Presence(), Presence()
    for presence in (at_once, one_by_one):
        presence.watch([1], 0.5)  # a robot watches before it sees any token
    shown = ((WORLD_NUMBER, "a"), (1, "b"), (2, "c"), (1, "d"))
    at_once.see(shown, 1.0)
    for robot, incarnation in shown:
        one_by_one.come(robot, incarnation, 1.0)
    assert vars(at_once) == vars(one_by_one)
    assert not at_once.has_gone_by(1, 2.0)


def test_what_was_known_of_robots_that_are_no_longer_watched_is_void() -> None:
    presence = connected(1, 2)
    presence.watch([2], 5.0)
    assert (there(presence, 6.0), presence.sees_all, presence.connected) == ({2}, False, True)
    assert not presence.is_lost(1, 1.0, 99.0), "nothing is known of it"


def test_a_robot_that_is_watched_and_shows_no_token_has_gone_by_then() -> None:
    presence = connected()
    presence.watch([3], 5.0)
    assert [presence.is_lost(3, 4.0, now_s) for now_s in (5.0, 5.0 + GRACE_S)] == [False, True]
    presence.come(3, "a", 5.0 + GRACE_S)
    assert not presence.is_lost(3, 4.0, 99.0)


def test_where_all_are_watched_one_that_shows_no_token_has_gone_by_then() -> None:
    presence = connected()
    presence.watch([], 1.0)
    presence.come(1, "a", 2.0)
    presence.watch(None, 5.0)
    assert (there(presence, 6.0), presence.sees_all) == ({1}, True)
    lost = [presence.is_lost(2, 4.0, now_s) for now_s in (5.0, 5.0 + GRACE_S)]
    assert (lost, presence.is_lost(1, 4.0, 99.0)) == ([False, True], False)
