"""Who keeps the others waiting in a lining up, as a conversation of three robots."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import pytest
from agents.membership.muster import Roster
from agents.membership.waiting import SLOW_S, SLOW_SHARE, STALLS_S, Waiting

from protocol.frames import Point, Pose
from protocol.mission import Law
from protocol.wire.messages import Muster, Turn
from tests.support.stages.one_step import under

MISSION = under(Law.CERTIFIED, robots=3, robot_radius_m=0.1, goal=Point(x_m=9.0, y_m=0.0))
TURN = Turn(number=1, robot=2)
FREE_AT_S = 3.0


def waited(
    made_m: Callable[[float], float] = lambda _: 0.0,
    *,
    answers: bool = True,
    leg_clear: bool | None = False,
    turn: Turn | None = TURN,
    order: Mapping[int, tuple[int, ...]] = MappingProxyType({}),
    for_s: float = 60.0,
) -> tuple[float, int] | None:
    """When robot 1 has waited for long enough, and for whom; robot 3 has given robot 2 the turn."""
    roster = Roster((1, 2, 3), MISSION.goal, 0.25)
    waiting = Waiting(1, MISSION, roster, 0.0)
    for beat in range(1, round(10.0 * for_s)):
        now_s = beat / 10.0
        for robot in (1, 2, 3):
            roster.hear(
                robot,
                Muster(
                    number=beat,
                    pose=Pose(x_m=float(-robot), y_m=0.0, heading_rad=0.0),
                    leg_clear=True if robot == 1 else leg_clear,
                    gives=turn if robot == 3 else None,
                    turn=0 if turn is None or (robot == 3 and not answers) else turn.number,
                    made_m=made_m(now_s) if robot == 2 else 0.0,
                    echo_s=now_s,
                    order=order.get(robot, ()),
                ),
            )
        waiting.note(now_s)
        who = waiting.stalled(now_s, free_at_s=FREE_AT_S, late_s=0.0)
        if who is not None:
            return now_s, who
    return None


def at_share(share: float) -> Callable[[float], float]:
    """A robot that drives steadily, at a share of the speed."""
    return lambda now_s: share * MISSION.speed_mps * max(now_s - FREE_AT_S, 0.0)


def test_who_makes_nothing_of_its_turn_is_slow_before_it_has_stood_for_long() -> None:
    assert waited() == pytest.approx((FREE_AT_S + SLOW_S, 2), abs=0.2)


def test_who_drove_fast_and_then_stands_has_stood_for_long() -> None:
    fast_m = MISSION.speed_mps * 60.0
    assert waited(lambda now_s: fast_m if now_s > FREE_AT_S + 1.0 else 0.0) == pytest.approx(
        (FREE_AT_S + 1.0 + STALLS_S, 2), abs=0.3
    )


def test_who_drives_fast_enough_is_waited_for_and_who_is_slow_however_steadily_is_not() -> None:
    assert waited(at_share(1.1 * SLOW_SHARE)) is None
    assert waited(at_share(0.5 * SLOW_SHARE)) == pytest.approx((FREE_AT_S + 2.0 * SLOW_S, 2), abs=0.3)


def test_where_another_does_not_answer_the_turn_it_is_that_one() -> None:
    assert waited(answers=False) == pytest.approx((FREE_AT_S + SLOW_S, 3), abs=0.2)


def test_who_does_not_look_at_its_leg_keeps_the_others_waiting_before_there_is_a_turn() -> None:
    assert waited(turn=None, leg_clear=None) == pytest.approx((SLOW_S, 2), abs=0.2)


def test_who_does_not_give_the_next_turn_keeps_the_others_waiting() -> None:
    assert waited(turn=None) == pytest.approx((FREE_AT_S + STALLS_S, 1), abs=0.2)


def test_when_all_are_in_place_it_is_who_does_not_say_so_and_else_who_does_not_lead() -> None:
    strand = (1, 2, 3)
    for robot, order in ((2, {1: strand, 3: strand}), (1, dict.fromkeys(strand, strand))):
        stalls = waited(turn=None, leg_clear=True, order=order)
        assert stalls == pytest.approx((FREE_AT_S + STALLS_S, robot), abs=0.2)
