"""A turn in a lining up as a conversation: when it may be driven, and who answers it."""

import dataclasses
import math

import numpy as np
from agents.membership.lining import Lining

from protocol.frames import Point
from tests.support.stages.lining_stage import (
    BOX,
    EPOCH,
    GOAL,
    PLACES,
    TURN,
    mission,
    says,
    says_of_call,
    scan_of,
    wants_scan,
)
from tests.support.stages.one_step import look_around
from world.geometry.shapes import Circle, Shape


def in_turn() -> Lining:
    """Robot 2, which has the turn to join robot 1; all others say that they stand in it."""
    fleet = mission(robots=3, goal=Point(x_m=-9.0, y_m=0.0))
    lining = Lining(2, fleet, 5.0, epoch=EPOCH, members=(1, 2, 3))
    says(lining, PLACES[2], None, 5.0)
    for robot in (1, 3):
        lining.hear(robot, says_of_call(robot, leg_clear=robot == 1), 5.1)
    post = Circle(centre_m=(1.5, 0.1), radius_m=0.05)
    says(lining, PLACES[2], look_around([*BOX, post], fleet, PLACES[2]), 5.2)
    gives = {"turn": 1, "echo_s": 5.2}
    lining.hear(1, says_of_call(1, 2, leg_clear=True, gives=TURN, **gives), 5.3)
    lining.hear(3, says_of_call(3, 2, leg_clear=False, **gives), 5.3)
    return lining


def looks_to_drive(lining: Lining, now_s: float) -> bool:
    says(lining, PLACES[2], None, now_s)
    return wants_scan(lining, PLACES[2])


def test_nobody_drives_before_whoever_is_left_out_must_stand() -> None:
    lining = in_turn()
    drives = [looks_to_drive(lining, 5.4)]
    lining.settled_at_s = 5.6
    drives += [looks_to_drive(lining, now_s) for now_s in (5.5, 5.7)]
    assert drives == [False, False, True]


def test_the_latest_time_that_any_member_knows_of_counts() -> None:
    lining = in_turn()
    lining.settled_at_s = 5.2
    drives = [looks_to_drive(lining, 5.3)]
    lining.hear(3, says_of_call(3, 3, leg_clear=False, turn=1, echo_s=5.3, free_s=5.6), 5.4)
    drives += [looks_to_drive(lining, now_s) for now_s in (5.5, 5.7)]
    assert drives == [True, False, True]


def test_nobody_drives_before_all_members_have_said_when_those_that_are_left_out_stand() -> None:
    lining = in_turn()
    lining.settled_at_s = 5.2
    lining.hear(3, says_of_call(3, 3, leg_clear=False, turn=1, echo_s=5.3, free_s=None), 5.4)
    drives = [looks_to_drive(lining, 5.5)]
    lining.hear(3, says_of_call(3, 4, leg_clear=False, turn=1, echo_s=5.5), 5.6)
    drives.append(looks_to_drive(lining, 5.7))
    assert drives == [False, True]


def test_a_robot_confirms_the_strand_only_when_it_knows_that_all_others_stand() -> None:
    fleet = mission(robots=3, goal=GOAL)
    lining = Lining(1, fleet, 5.0, epoch=EPOCH, members=(1, 2, 3))
    lining.settled_at_s = 5.0
    says(lining, PLACES[1], None, 5.0)
    for robot, free_s in ((2, 5.0), (3, None)):
        lining.hear(robot, says_of_call(robot, leg_clear=True, free_s=free_s), 5.1)
    orders = [says(lining, PLACES[1], scan_of(1, fleet), 5.2)[-1].order]
    lining.hear(3, says_of_call(3, 2, leg_clear=True), 5.3)
    orders.append(says(lining, PLACES[1], None, 5.4)[-1].order)
    assert orders == [(), (3, 2, 1)]


def test_nobody_joins_by_a_scan_from_before_whoever_is_left_out_must_stand() -> None:
    lining = in_turn()
    lining.settled_at_s = 5.6
    seen = look_around(BOX, mission(robots=3, goal=GOAL), PLACES[2])
    ranks = []
    for taken_s in (5.5, 5.6):
        said = says(lining, PLACES[2], dataclasses.replace(seen, t_s=taken_s), 5.2 + taken_s / 10.0)
        ranks.append([muster.rank for muster in said])
    assert ranks == [[None], [1]]


def test_who_has_had_its_turn_in_vain_finds_no_way() -> None:
    lining = in_turn()
    lining.settled_at_s = 5.2
    found = [lining.finds_no_way]
    posts: list[Shape] = [
        Circle(centre_m=(2.0 + 0.5 * math.cos(angle), 0.5 * math.sin(angle)), radius_m=0.15)
        for angle in np.linspace(0.0, 2.0 * math.pi, 12)
    ]
    shut_in = look_around(posts, mission(robots=3, goal=GOAL), PLACES[2])
    said = says(lining, PLACES[2], dataclasses.replace(shut_in, t_s=5.3), 5.3)
    found.append(lining.finds_no_way)
    assert [(muster.ended, muster.rank) for muster in said] == [(1, None)]
    assert found == [False, True]


def test_who_has_the_turn_drives_only_while_all_others_echo_what_it_said_of_late() -> None:
    lining = in_turn()
    lining.settled_at_s = 5.0
    silence_s = mission(robots=3, goal=None).silence_s
    drives = [looks_to_drive(lining, 5.2 + silence_s - 0.1), looks_to_drive(lining, 5.2 + silence_s + 0.1)]
    lining.hear(1, says_of_call(1, 3, leg_clear=True, gives=TURN, turn=1, echo_s=6.2), 6.3)
    drives.append(looks_to_drive(lining, 6.4))
    lining.hear(3, says_of_call(3, 3, leg_clear=False, turn=1, echo_s=6.2), 6.4)
    drives.append(looks_to_drive(lining, 6.5))
    assert drives == [True, False, False, True]


def test_an_echo_of_what_is_yet_to_be_said_is_no_answer_to_who_has_the_turn() -> None:
    lining = in_turn()
    lining.settled_at_s = 5.0
    lining.hear(3, says_of_call(3, 3, leg_clear=False, turn=1, echo_s=9.0), 5.4)
    drives = [looks_to_drive(lining, 5.5)]
    lining.hear(3, says_of_call(3, 4, leg_clear=False, turn=1, echo_s=5.4), 5.6)
    drives.append(looks_to_drive(lining, 5.7))
    assert drives == [False, True]


def third(*, echo_s: float, now_s: float, mover_t_s: float = 0.0, in_turn: int = 1) -> float:
    """What robot 3 echoes while robot 2 has turn 1, when robot 1 has echoed so much in some turn."""
    lining = Lining(3, mission(robots=3, goal=GOAL), 5.0, epoch=EPOCH, members=(1, 2, 3))
    says(lining, PLACES[3], None, 5.0)
    lining.hear(2, says_of_call(2, turn=1, t_s=mover_t_s), 5.1)
    lining.hear(1, says_of_call(1, gives=TURN, turn=in_turn, echo_s=echo_s), 5.1)
    return says(lining, PLACES[3], None, now_s)[-1].echo_s


def test_what_a_robot_has_not_heard_itself_it_echoes_where_another_has_heard_it() -> None:
    assert third(mover_t_s=5.0, echo_s=6.0, now_s=6.1) == 6.0
    assert third(mover_t_s=6.0, echo_s=5.0, now_s=6.1) == 6.0


def test_who_misses_odometry_too_echoes_what_another_has_heard_by_a_clock_a_little_ahead() -> None:
    assert third(mover_t_s=5.0, echo_s=6.5, now_s=6.1) == 6.5


def test_an_echo_of_whoever_had_the_turn_before_is_not_passed_on() -> None:
    assert third(mover_t_s=5.0, echo_s=6.0, now_s=6.1, in_turn=0) == 5.0


def test_an_echo_that_no_clock_can_account_for_is_not_passed_on() -> None:
    assert third(mover_t_s=5.0, echo_s=60.0, now_s=6.1) == 5.0
