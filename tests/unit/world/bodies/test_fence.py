"""The register of the fence, in conversations."""

import pytest
from msgspec.structs import replace

from protocol.fence import Bearing, Cause, Change, Epoch, Fence, May, Raise, Release, Stop, Turn, obeys
from tests.support.registers import OPERATOR, ROBOTS, Talk, all_of, epoch, life_of, nobody, one, raised
from world.bodies.fence import OUTSIDERS_S, Register
from world.quota import BACK_S, BACK_S_MAX, RAISES_MAX


def test_a_run_begins_with_a_fence_under_which_nobody_may_move() -> None:
    assert Register(ROBOTS).fence == Fence()
    assert not any(obeys(Fence(), robot, Bearing(life=life_of(robot))) for robot in range(1, ROBOTS + 1))


def test_a_view_is_raised_gives_turns_and_comes_to_all() -> None:
    talk, mine = Talk(), epoch(1, 2)
    assert talk.put(2, raised(1, 2))
    assert talk.at() == (1, 2, 0, May.NOBODY)
    assert talk.put(2, one(mine, 1, 3))
    assert talk.register.fence.names(3, life_of(3))
    assert talk.put(2, nobody(mine, 2))
    assert talk.put(2, one(mine, 3, 4))
    assert talk.put(2, nobody(mine, 4))
    assert talk.put(2, all_of(mine, 5, leader=3, members=4))
    assert talk.at() == (1, 2, 5, May.ALL)
    assert (talk.register.fence.robot, talk.register.fence.members) == (3, 4)


def test_what_has_been_taken_changes_nothing_when_it_is_repeated() -> None:
    talk, mine = Talk(), epoch(1, 2)
    puts: list[Change] = [raised(1, 2), one(mine, 1, 3), nobody(mine, 2), all_of(mine, 3)]
    for place, change in enumerate(puts):
        assert talk.put(2, change)
        assert not any(talk.put(2, earlier) for earlier in puts[: place + 1])


def test_a_raise_goes_up_by_one_generation_and_no_more() -> None:
    talk = Talk()
    assert not talk.put(1, raised(2, 1))
    assert not talk.put(1, raised(2**39, 1))
    assert talk.put(1, raised(1, 1))


def test_the_higher_number_wins_within_a_generation_while_no_turn_was_taken() -> None:
    talk = Talk()
    assert talk.put(2, raised(1, 2))
    assert not talk.put(1, raised(1, 1))
    assert not talk.put(2, raised(1, 2, start=2))  # an equal number changes nothing, whatever its life
    assert talk.put(3, raised(1, 3))
    assert talk.put(3, nobody(epoch(1, 3), 1))
    assert not talk.put(4, raised(1, 4))  # V8: it came late, and stops no view that goes on
    assert talk.put(4, raised(2, 4))


def test_a_raise_counts_only_under_its_robots_own_key_and_with_a_life() -> None:
    talk = Talk()
    assert not talk.put(2, raised(1, 3))
    assert not talk.put(OPERATOR, raised(1, 3))
    assert not talk.put(OPERATOR, Raise(epoch=Epoch(generation=1), cause=Cause.START))
    assert not talk.put(3, Raise(epoch=Epoch(generation=1, robot=3), cause=Cause.START))
    assert not talk.put(ROBOTS + 1, raised(1, ROBOTS + 1))


def test_turns_come_from_the_robot_and_the_life_that_proposed_the_epoch() -> None:
    talk, mine = Talk(), epoch(1, 2)
    talk.put(2, raised(1, 2))
    assert not talk.put(3, one(mine, 1, 3))
    assert not talk.put(OPERATOR, one(mine, 1, 3))
    assert not talk.put(2, one(epoch(1, 2, start=2), 1, 3))  # V1: its new life coordinates no old view
    assert not talk.put(3, one(epoch(1, 3), 1, 3))
    assert talk.put(2, one(mine, 1, 3))


def test_turns_are_taken_one_after_the_other() -> None:
    talk, mine = Talk(), epoch(1, 2)
    talk.put(2, raised(1, 2))
    assert not talk.put(2, one(mine, 2, 3))
    assert not talk.put(2, nobody(mine, 0))
    assert talk.put(2, one(mine, 1, 3))
    assert not talk.put(2, one(mine, 1, 4))  # V19: a turn has one content
    assert not talk.put(2, one(mine, 3, 4))


def test_there_is_no_turn_after_all() -> None:
    talk = Talk()
    mine = talk.formed(2)
    assert not talk.put(2, nobody(mine, 2))
    assert not talk.put(2, one(mine, 2, 3))
    assert not talk.put(2, all_of(mine, 2))


@pytest.mark.parametrize(
    "fence",
    [
        Fence(may=May.ONE, robot=ROBOTS + 1, life=7),
        Fence(may=May.ONE, robot=0, life=7),
        Fence(may=May.ONE, robot=3, life=0),
        Fence(may=May.ONE, robot=3, life=7, members=1),
        Fence(may=May.NOBODY, robot=3),
        Fence(may=May.NOBODY, members=3),
        Fence(may=May.ALL, robot=0, members=3),
        Fence(may=May.ALL, robot=1, members=0),
        Fence(may=May.ALL, robot=1, members=ROBOTS + 1),
        Fence(may=May.STOPPED),
    ],
)
def test_a_turn_names_whom_it_has_to_name_and_nobody_else(fence: Fence) -> None:
    talk = Talk()
    talk.put(2, raised(1, 2))
    assert not talk.put(2, Turn(fence=replace(fence, epoch=epoch(1, 2), turn=1)))


# --- the operator, and a world that is started again ----------------------------------------------


def test_a_stop_refuses_every_raise_and_turn_until_its_release() -> None:
    talk = Talk()
    mine = talk.formed(2)
    assert talk.put(OPERATOR, Stop())
    assert talk.at() == (2, 0, 0, May.STOPPED)
    assert not talk.put(OPERATOR, Stop())
    assert not talk.put(3, raised(3, 3))  # V11
    assert not talk.put(3, raised(2, 3))
    assert not talk.put(2, nobody(mine, 2))
    assert talk.put(OPERATOR, Release(generation=2))
    assert talk.at() == (3, 0, 0, May.NOBODY)
    assert talk.put(1, raised(4, 1))


def test_a_late_release_does_not_end_a_second_stop() -> None:
    talk = Talk()
    for generation in (1, 3):
        assert talk.put(OPERATOR, Stop())
        assert talk.at()[0] == generation
        assert not talk.put(OPERATOR, Release(generation=1)) or generation == 1
    assert talk.at() == (3, 0, 0, May.STOPPED)
    assert talk.put(OPERATOR, Release(generation=3))
    assert not talk.put(OPERATOR, Release(generation=3))


def test_only_the_operator_stops_and_releases() -> None:
    talk = Talk()
    assert not talk.put(1, Stop())
    talk.put(OPERATOR, Stop())
    assert not talk.put(1, Release(generation=1))


def test_a_world_that_is_started_again_raises_the_fence_and_keeps_a_stop() -> None:
    talk = Talk()
    mine = talk.formed(2)
    taken = talk.register.restart(now_s=0.0)
    assert (taken.cause, talk.at()) == (Cause.WORLD_RESTARTED, (2, 0, 0, May.NOBODY))
    assert not talk.put(2, nobody(mine, 2))
    assert talk.put(3, raised(3, 3))
    talk.put(OPERATOR, Stop())
    talk.register.restart(now_s=0.0)
    assert talk.at() == (5, 0, 0, May.STOPPED)
    assert not talk.put(3, raised(6, 3))


def test_any_robot_may_raise_over_a_world_that_was_started_again() -> None:
    talk = Talk()
    talk.register.restart(now_s=0.0)
    assert talk.put(1, raised(1, 1))  # it was put before, and is of the same generation


# --- outsiders ------------------------------------------------------------------------------------


def test_raises_of_outsiders_over_all_are_held_until_they_are_more_than_the_members() -> None:
    talk = Talk()
    talk.formed(1, members=1)
    assert not talk.put(2, raised(2, 2, outsider=True))
    assert not talk.put(2, raised(2, 2, outsider=True))  # the same one, again
    assert talk.put(3, raised(2, 3, outsider=True))
    assert talk.at() == (2, 3, 0, May.NOBODY)


def test_outsiders_that_asked_long_ago_do_not_count() -> None:
    talk = Talk()
    talk.formed(1, members=1)
    assert not talk.put(2, raised(2, 2, outsider=True))
    talk.now_s = OUTSIDERS_S + 0.1
    assert not talk.put(3, raised(2, 3, outsider=True))
    assert talk.put(2, raised(2, 2, outsider=True))


def test_outsiders_of_an_earlier_strand_do_not_count() -> None:
    talk = Talk()
    talk.formed(1, members=1)
    assert not talk.put(2, raised(2, 2, outsider=True))
    talk.formed(1, members=1)
    assert not talk.put(3, raised(3, 3, outsider=True))


def test_a_member_raises_over_all_at_once() -> None:
    talk = Talk()
    talk.formed(1)
    assert talk.put(2, raised(2, 2))


def test_an_outsider_raises_at_once_where_there_is_no_strand() -> None:
    assert Talk().put(2, raised(1, 2, outsider=True))


# --- the quota ------------------------------------------------------------------------------------


def test_a_robot_that_raises_again_and_again_has_to_wait_and_others_need_not() -> None:
    talk = Talk()
    for generation in range(1, RAISES_MAX + 1):
        assert talk.put(3, raised(generation, 3))
    assert not talk.put(3, raised(RAISES_MAX + 1, 3))
    assert talk.put(2, raised(RAISES_MAX + 1, 2))


def waits_s(talk: Talk, robot: int) -> float:
    """How long the robot has to wait for its next raise."""
    began_s = talk.now_s
    while not talk.put(robot, raised(talk.at()[0] + 1, robot)):
        talk.now_s += 1.0
    return talk.now_s - began_s


def test_a_raise_comes_back_after_a_while_and_more_slowly_for_views_in_vain() -> None:
    talk = Talk()
    for _ in range(RAISES_MAX):
        talk.formed(1)
    # A view is in vain when the next one ends it.
    assert [waits_s(talk, 1) for _ in range(4)] == [BACK_S, BACK_S, 2 * BACK_S, 4 * BACK_S]


def test_however_often_its_views_were_in_vain_a_robot_may_raise_again() -> None:
    talk = Talk()
    for _ in range(20):
        last_s = waits_s(talk, 1)
    assert last_s == BACK_S_MAX


def test_a_view_that_comes_to_all_ends_the_row() -> None:
    talk = Talk()
    for _ in range(RAISES_MAX + 2):
        waits_s(talk, 1)
    talk.put(1, all_of(epoch(talk.at()[0], 1), 1))
    assert waits_s(talk, 1) <= BACK_S


def test_a_view_that_the_operator_or_a_higher_number_ends_is_not_in_vain() -> None:
    talk = Talk()
    for _ in range(RAISES_MAX):
        generation = talk.at()[0] + 1
        talk.put(1, raised(generation, 1))
        talk.put(OPERATOR, Stop())
        talk.put(OPERATOR, Release(generation=generation + 1))
    assert waits_s(talk, 1) == BACK_S
