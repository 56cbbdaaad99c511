"""Whose tokens a robot watches, and how they come to its core."""

from agents.events import Event, TokensSeen, TokensWatched
from agents.process.addresses import ALL_ALIVE, alive
from agents.process.journal import Given
from agents.process.watching import at_once, beside, watched_by
from protocol.process.tokens import TokenCame, TokenWent


def given(event: Event) -> Given:
    key = alive(event.robot, event.incarnation) if isinstance(event, TokenCame | TokenWent) else ALL_ALIVE
    return Given(event, key, 0)


def together(*events: Event) -> list[Event]:
    return [each.event for each in at_once([given(event) for event in events])]


def test_it_always_watches_the_robot_beside_it_and_it_may_watch_all() -> None:
    assert [beside(robot) for robot in (1, 2, 3)] == [2, 1, 2]
    assert watched_by(3, frozenset()) == frozenset({2})
    assert watched_by(3, frozenset({4, 7})) == frozenset({2, 4, 7})
    assert watched_by(3, None) is None


def test_tokens_that_come_one_after_the_other_are_one_event() -> None:
    one, two, again, listed = TokenCame(1, "a"), TokenCame(2, "b"), TokenCame(1, "c"), TokensWatched(None)
    assert together(one, two, again, listed) == [TokensSeen(((1, "a"), (2, "b"), (1, "c"))), listed]
    assert at_once([given(one), given(two)])[0].key == ALL_ALIVE


def test_what_comes_between_two_tokens_stays_between_them() -> None:
    one, went, two = TokenCame(1, "a"), TokenWent(1, "a"), TokenCame(2, "b")
    assert together(one, went, two) == [one, went, two]
    assert together() == []
