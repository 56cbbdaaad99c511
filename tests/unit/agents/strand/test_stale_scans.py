"""A scan from before the robots left out must stand, which arrives when the strand has formed."""

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.strand.member import Member
from agents.strand.memory import Memory
from protocol.wire.messages import Odometry, Phase, Scan
from tests.support.stages.strand_stage import MISSION, ORDER, PLACES, place

LEADER = ORDER[0]
FREE_AT_S = 6.0


def test_a_strand_does_not_use_a_scan_from_before_it_may_drive() -> None:
    driver = Driver(speed_mps=MISSION.speed_mps)
    driver.hear(Odometry(t_s=0.0, pose=PLACES[LEADER], moving=False, finished=0, phase=Phase.RUNNING))
    senses = Senses(MISSION, driver)
    Member(MISSION, driver, senses, place(LEADER), Memory(MISSION), free_at_s=FREE_AT_S)
    believed = []
    for t_s in (FREE_AT_S - 0.1, FREE_AT_S):
        senses.hear(Scan(t_s=t_s, pose=PLACES[LEADER], ranges_m=(1.0,) * MISSION.directions))
        believed.append(senses.take() is not None)
    assert believed == [False, True]
