"""F4 and P3: what a formation must be."""

import pytest
from msgspec.structs import replace

from protocol.fence import May
from protocol.timeline import RobotDied, StrandFormed, StrandJoined
from tests.support.histories.entries import Said
from tests.support.histories.fenced import (
    FIRST,
    LIVES,
    SECOND,
    broken,
    fence,
    formation,
    grant,
    order,
    run,
    scan,
)

FORMED = formation(FIRST, 3, 1.2, 0.6, 0.0)


def formed(strand: StrandFormed = FORMED, *, t_s: float = 1.9, by: str = "r2") -> Said:
    return t_s, by, strand


def driven(**fields: int) -> Said:
    return 2.0, "world", replace(fence(FIRST, 3, May.ALL, named=1, members=3), **fields)


UNLAWFUL: dict[str, list[Said]] = {
    "none": run(without=("formed",)),
    "of another robot than the coordinator": run(formed=formed(by="r1")),
    "made twice": run((2.5, "r2", FORMED)),
    "made by two": run((2.5, "r1", FORMED)),
    "of another turn": run(formed=formed(replace(FORMED, turn=4))),
    "another robot leads": run(all=driven(named=2)),
    "another number of members": run(all=driven(members=2)),
    "made too late": run(formed=formed(t_s=2.05)),
    "made before a turn": run(formed=formed(t_s=0.35)),
    "made in another life": run(
        formed=formed(replace(FORMED, lives=("1a", "ff", "3c"))), without=("order 2", "drive 2", "there 2")
    ),
    "right after a turn of a robot": run(turn_2=(1.8, "world", fence(FIRST, 2, May.ONE, named=3))),
    "a member that stands elsewhere drives": run(formed=formed(replace(FORMED, places_m=(1.2, 0.5, 0.0)))),
    "another life drives": run(
        order_2=(2.92, "world", order(2, (-0.6, 0.0), (-0.2, 0.0), reach_m=1.0, life="ff"))
    ),
    "a rank of another": run(rank_3=(2.1, "r3", StrandJoined(epoch=FIRST, rank=1))),
    "a rank of no member": run((2.1, "r4", StrandJoined(epoch=FIRST, rank=2))),
    "a rank before ALL": run(rank_3=(1.95, "r3", StrandJoined(epoch=FIRST, rank=2))),
    "a rank in an epoch without ALL": run(
        (5.1, "r3", StrandJoined(epoch=SECOND, rank=2)),
        without=("all again", "order 1 again", "drive 1 again", "there 1 again"),
    ),
    "made before its epoch": run(formed_again=(3.8, "r3", formation(SECOND, 1, 2.0, 1.0, 0.0))),
}


@pytest.mark.parametrize("said", UNLAWFUL.values(), ids=UNLAWFUL.keys())
def test_each_formation_that_is_not_the_one_of_its_fences_is_a_violation(said: list[Said]) -> None:
    assert broken(said) == ["F4"]


def test_a_member_that_stands_elsewhere_and_does_not_drive_is_lawful() -> None:
    elsewhere = formed(replace(FORMED, places_m=(1.2, 0.5, 0.0)))
    assert broken(run(formed=elsewhere, without=("order 2", "drive 2", "there 2"))) == []


def test_a_member_may_stand_as_far_from_its_place_as_the_tolerance() -> None:
    assert broken(run(formed=formed(replace(FORMED, places_m=(1.2, 0.609, 0.0))))) == []
    assert broken(run(formed=formed(replace(FORMED, places_m=(1.2, 0.611, 0.0))))) == ["F4"]


def test_a_coordinator_need_not_be_a_member() -> None:
    without_2 = formation(FIRST, 3, 1.2, 0.0, order=(1, 3))
    said = run(
        formed=formed(without_2),
        all=driven(members=2),
        rank_3=(2.1, "r3", StrandJoined(epoch=FIRST, rank=1)),
        without=("rank 2", "grant 2", "order 2", "drive 2", "there 2"),
    )
    assert broken(said) == []


def test_a_formation_of_an_epoch_that_never_was_is_a_violation() -> None:
    assert broken(run((5.1, "r1", formation(30_001, 1, 2.0, 1.0, 0.0)))) == ["F4"]


def test_an_epoch_that_begins_with_all_is_a_violation_and_no_crash() -> None:
    still = ("plan 1 again", "order 1 again", "drive 1 again", "there 1 again", "joined 1 again")
    assert set(broken(run(without=("raised again", *still)))) == {"F3", "F4"}


def test_a_member_that_stands_elsewhere_is_one_violation_though_it_drives_on() -> None:
    elsewhere = formed(replace(FORMED, places_m=(1.2, 0.5, 0.0)))
    more = order(2, (-0.2, 0.0), (-0.1, 0.0), reach_m=1.1)
    again: list[Said] = [(3.75, "r1", grant(1.1)), (3.8, "world", more)]
    assert broken(run(*again, formed=elsewhere)) == ["F4"]


DEAD: Said = (3.0, "world", RobotDied(robot=2, silent_since_s=1.8))
"""The coordinator was killed, and its last entries never came."""


def test_the_formation_of_a_coordinator_that_was_killed_may_be_missing() -> None:
    assert broken(run(DEAD, without=("formed", "rank 2"))) == []


def test_a_put_of_all_may_arrive_after_the_death_of_its_coordinator() -> None:
    early: Said = (1.9, "world", RobotDied(robot=2, silent_since_s=1.8))
    assert broken(run(early, without=("formed", "rank 2"))) == []


def test_the_formation_is_not_missing_where_later_entries_of_the_coordinator_came() -> None:
    assert broken(run(DEAD, without=("formed",))) == ["F4"]


def test_the_death_of_another_robot_or_in_an_earlier_turn_excuses_nothing() -> None:
    other: Said = (3.0, "world", RobotDied(robot=1, silent_since_s=1.8))
    assert "F4" in broken(run(other, without=("formed", "rank 2")))
    earlier: Said = (0.3, "world", RobotDied(robot=2, silent_since_s=0.1))
    assert broken(run(earlier, without=("formed", "rank 2"))) == ["F4"]


MISSHAPEN: dict[str, StrandFormed] = {
    "a robot twice": formation(SECOND, 1, 2.0, 1.0, 0.5, 0.0, order=(1, 2, 3, 2)),
    "places that do not go back": formation(SECOND, 1, 2.0, 0.0, 1.0),
    "a place beyond the path": replace(formation(SECOND, 1, 2.0, 1.0, 0.0), places_m=(2.1, 1.0, 0.0)),
    "a place too few": replace(formation(SECOND, 1, 2.0, 1.0, 0.0), places_m=(2.0, 1.0)),
    "a life too few": replace(formation(SECOND, 1, 2.0, 1.0, 0.0), lives=(LIVES[1], LIVES[2])),
    "no path": replace(formation(SECOND, 1, 2.0, 1.0, 0.0), laid=()),
}


@pytest.mark.parametrize("strand", MISSHAPEN.values(), ids=MISSHAPEN.keys())
def test_a_formation_names_each_robot_once_and_in_order_along_its_path(strand: StrandFormed) -> None:
    said = run(
        formed_again=(4.4, "r3", strand),
        all_again=(4.5, "world", fence(SECOND, 1, May.ALL, named=1, members=len(strand.order))),
        without=("order 1 again", "drive 1 again", "there 1 again"),
    )
    assert broken(said) == ["P3"]


@pytest.mark.parametrize("strand", MISSHAPEN.values(), ids=MISSHAPEN.keys())
def test_orders_in_a_misshapen_formation_are_judged_as_far_as_it_goes(strand: StrandFormed) -> None:
    last = strand.order[2]
    drive = order(last, (-1.2, 0.0), (-1.2, 0.0), epoch=SECOND, turn=1)
    more: list[Said] = [
        (4.52, "world", scan(last)),
        (4.8, "world", drive),
        (4.75, "r2", grant(0.5, to=last, epoch=SECOND)),
    ]
    all_again: Said = (4.5, "world", fence(SECOND, 1, May.ALL, named=1, members=len(strand.order)))
    assert "P3" in broken(run(*more, formed_again=(4.4, "r3", strand), all_again=all_again))


def test_an_order_of_a_robot_that_was_never_sampled_is_no_crash() -> None:
    assert broken(run(without=("place 2", "drive 2", "there 2"))) == []
