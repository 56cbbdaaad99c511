"""Schedules of an adversary: a robot's clock lags while another robot is left out and still moves."""

import pytest

from clew.rehearsal.rehearsal import Rehearsal
from protocol.faults.plan import Plan
from protocol.faults.rules import Delay, Drop, Kill, Rule
from protocol.fence import May
from protocol.timeline import FenceChanged
from tests.support.long import long
from tests.support.scenes.placed import placed
from world.judge.ending import Ending
from world.judge.judgement import judge
from world.scenario.scenario import Scenario

CART = {
    "id": "cart",
    "shape": "circle",
    "radius_m": 0.1,
    "track": [(0.0, 9.5, 2.5), (60.0, 9.5, 2.0), (100.0, 9.5, 2.5)],
}


def world(*, cart: bool = False, goal_x_m: float = 8.0) -> Scenario:
    """Four robots in a row, and one far behind that joins by a turn."""
    return placed(
        "late-odometry",
        [(2.0, 0.0), (1.0, 0.0), (0.0, 0.0), (-1.0, 0.0), (-10.0, 0.5)],
        (goal_x_m, 0.0),
        fleet={"robot_radius_m": 0.15, "link_length_m_max": 1.5, "deployment": "random"},
        law={"epsilon_m": 0.05, "mu0_m": 0.005},
        goal={"tolerance_m": 0.45},
        bounds={"x_m_min": -12.0, "y_m_min": -3.0, "x_m_max": 10.0, "y_m_max": 3.0},
        sensor={"directions": 180, "range_sigma_m": 0.0004},
        drive={"speed_mps": 0.3, "turn_rate_radps": 1.5708, "heading_error_rad": 0.0001},
        time={"time_s_max": 120.0},
        moving=[CART] if cart else [],
    )


def leader_lags(until_s: float, *, from_s: float = 0.0) -> Delay:
    """The leader's odometry is three seconds old when it arrives."""
    return Delay(
        from_s=from_s,
        until_s=until_s,
        receiver=("r1",),
        kinds=("odometry",),
        delay_s_min=3.0,
        delay_s_max=3.001,
    )


def dies_in_its_turn(*, lags_from_s: float) -> tuple[Rule, ...]:
    return (leader_lags(9.65, from_s=lags_from_s), Kill(from_s=9.0, target="r5"))


def is_not_heard_in_its_turn(*, until_s: float) -> tuple[Rule, ...]:
    """Nobody receives robot 5's reports any more, then robot 5 receives nothing."""
    return (
        leader_lags(until_s),
        Drop(from_s=5.0, until_s=31.58, sender=("r5",), kinds=("report",)),
        Drop(from_s=11.58, until_s=31.58, receiver=("r5",), kinds=("answer", "formation", "ahead", "behind")),
    )


SCHEDULES = {
    "a death, with a lag from the start": dies_in_its_turn(lags_from_s=0.0),
    "a death, with a lag for a while": dies_in_its_turn(lags_from_s=5.0),
    "a robot is not heard in its turn": is_not_heard_in_its_turn(until_s=11.8),
}
SHOWN = ("a death, with a lag for a while", "a robot is not heard in its turn")


@pytest.mark.parametrize("schedule", [*SHOWN, *long(each for each in SCHEDULES if each not in SHOWN)])
def test_no_robot_drives_before_those_left_out_stand_even_if_its_odometry_is_late(
    schedule: str,
) -> None:
    scenario = world()
    rehearsal = Rehearsal(scenario, 1, Plan(name="test", rules=SCHEDULES[schedule])).run()
    assert judge(scenario, rehearsal.entries).breaches == ()
    fences = [entry.record for _, entry in rehearsal.entries if isinstance(entry.record, FenceChanged)]
    assert [fence.named for fence in fences if fence.may is May.ONE] == [5], "it had its turn"


def test_a_robot_whose_orders_were_lost_for_long_joins_later() -> None:
    lost = Drop(until_s=14.0, sender=("r5",), kinds=("drive",))
    rehearsal = Rehearsal(world(cart=True, goal_x_m=4.0), 1, Plan(name="test", rules=(lost,))).run()
    assert rehearsal.world.ending is Ending.ARRIVED
