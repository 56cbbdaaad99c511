"""Faults at a point of a robot's step: effects on other robots do not count as its own."""

from pathlib import Path

import pytest

from agents.events import ScanHeard
from agents.process.victim import Victim
from protocol.faults.plan import Plan
from protocol.faults.process_faults import ProcessAction, ProcessFault
from protocol.faults.rules import Freeze, Kill, Restart, Rule, StepPoint
from protocol.fence import Fence
from protocol.frames import Point
from protocol.network.faulty_transport import Conditions
from protocol.timeline import StrandFormed
from protocol.wire.messages import Faults, Scan
from tests.support.strategies.scans import ORIGIN

SCANNED = ScanHeard(Scan(t_s=2.0, pose=ORIGIN, ranges_m=(4.0,) * 8, fence=Fence()))
FORMED = StrandFormed(
    epoch=10_001,
    turn=1,
    order=(1, 2, 3),
    lives=("a", "b", "c"),
    places_m=(2.0, 1.0, 0.0),
    laid=(Point(x_m=-2.0, y_m=0.0), Point(x_m=0.0, y_m=0.0)),
    driven=(False, False, False),
    back_by_m=0.0,
    sensed=True,
)
AT_SCAN = Kill(target="leader", point=StepPoint.AFTER_SCAN)


def victim(*rules: Rule, again: bool = False) -> Victim:
    made = Victim(1, Path(), Conditions(Plan(name="test", rules=rules)), again=again)
    made.note(FORMED, 0.5)
    return made


def faults(*struck: str, step: int = 0, number: int = 1) -> Faults:
    return Faults(number=number, step=step, struck=struck, rules=(), slow_s=0.0)


@pytest.mark.parametrize(
    "other", [Kill(target="r2", from_s=1.0), Restart(target="tail"), Freeze(target="router", from_s=1.0)]
)
def test_effects_on_other_processes_do_not_spare_a_robot_at_its_point(other: Rule) -> None:
    robot = victim(other, AT_SCAN)
    assert robot.faults_at(SCANNED, [], 2.0, faults(f"{other.fault}-1")) == [
        ProcessFault("kill-2", ProcessAction.KILL, "r1")
    ]


def test_a_rule_that_has_taken_effect_elsewhere_has_no_further_effect() -> None:
    assert not victim(AT_SCAN).faults_at(SCANNED, [], 2.0, faults("kill-1"))


def test_all_rules_that_are_due_at_a_point_strike_up_to_a_kill() -> None:
    freeze = Freeze(target="r1", point=StepPoint.AFTER_SCAN)
    struck = victim(freeze, AT_SCAN, AT_SCAN, freeze).faults_at(SCANNED, [], 2.0, faults())
    assert [fault.rule for fault in struck] == ["freeze-1", "kill-2"]


def test_a_restarted_robot_waits_until_it_knows_which_rules_took_effect() -> None:
    robot = victim(AT_SCAN, again=True)
    assert not robot.faults_at(SCANNED, [], 2.0, faults(number=0))
    assert not robot.faults_at(SCANNED, [], 2.1, faults("kill-1"))


def test_a_follower_knows_the_leaders_step_from_the_fault_messages() -> None:
    robot = victim(Kill(target="r1", point=StepPoint.AFTER_SCAN, from_step=3))
    assert not robot.faults_at(SCANNED, [], 2.0, faults(step=2))
    assert robot.faults_at(SCANNED, [], 2.1, faults(step=3)) == [
        ProcessFault("kill-1", ProcessAction.KILL, "r1")
    ]
