"""A robot and its sensor: queries, repetitions, and the answers that are accepted."""

from agents.body.driver import Driver
from agents.body.senses import RETRY_S, Senses
from agents.commands import AskScan
from protocol.frames import Pose
from protocol.mission import Law
from protocol.wire.messages import Odometry, Phase, Scan
from tests.support.stages.one_step import under

MISSION = under(Law.CERTIFIED, directions=8, revolutions=2)
HERE, THERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), Pose(x_m=1.0, y_m=0.0, heading_rad=0.0)


def standing(at: Pose = HERE) -> tuple[Senses, Driver]:
    driver = Driver(speed_mps=MISSION.speed_mps)
    driver.hear(Odometry(t_s=0.0, pose=at, moving=False, finished=0, phase=Phase.RUNNING))
    return Senses(MISSION, driver), driver


def scan(at: Pose = HERE, *, t_s: float = 0.0, revolutions: int = 2, range_m: float = 9.0) -> Scan:
    return Scan(t_s=t_s, pose=at, ranges_m=(range_m,) * (revolutions * MISSION.directions))


def test_a_query_is_repeated_only_if_no_answer_has_come_for_a_while() -> None:
    senses, _ = standing()
    asked = [senses.ask(now_s) for now_s in (0.0, 0.9 * RETRY_S, RETRY_S)]
    assert asked == [[AskScan(MISSION.revolutions)], [], [AskScan(MISSION.revolutions)]]


def test_a_closer_look_is_a_query_with_more_revolutions() -> None:
    senses, _ = standing()
    assert senses.ask(0.0, revolutions=8) == [AskScan(8)]


def test_an_answer_is_used_once_and_then_the_next_query_may_be_sent_at_once() -> None:
    senses, _ = standing()
    senses.ask(0.0)
    senses.hear(scan())
    assert senses.take() is not None
    assert senses.take() is None
    assert senses.ask(0.1) != []


def test_a_scan_from_another_place_is_neither_used_nor_kept() -> None:
    senses, driver = standing()
    senses.hear(scan(THERE))
    assert senses.take() is None
    driver.hear(Odometry(t_s=1.0, pose=THERE, moving=False, finished=0, phase=Phase.RUNNING))
    assert senses.take() is None


def test_a_scan_from_before_the_robots_left_out_must_stand_is_not_used() -> None:
    senses, _ = standing()
    senses.trust_from(2.0)
    senses.trust_from(1.0)
    senses.hear(scan(t_s=1.9))
    assert senses.take() is None
    senses.hear(scan(t_s=2.0))
    assert senses.take() is not None


def test_a_scan_with_too_few_revolutions_is_a_late_answer_to_another_query() -> None:
    senses, _ = standing()
    senses.hear(scan(revolutions=2))
    assert senses.take(revolutions=8) is None
    senses.hear(scan(revolutions=8))
    assert senses.take(revolutions=8) is not None


def test_hits_beyond_the_range_count_as_not_seen() -> None:
    senses, _ = standing()
    senses.hear(scan(range_m=9.0))
    seen = senses.take()
    assert seen is not None
    assert not seen.hits.any()
    assert seen.ranges_m.max() == MISSION.range_m_max


def test_a_glimpse_is_accepted_from_any_place_but_not_from_before() -> None:
    senses, _ = standing()
    senses.hear(scan(THERE, t_s=1.0))
    assert senses.glimpse(2.0) is None
    senses.hear(scan(THERE, t_s=3.0))
    glimpse = senses.glimpse(2.0)
    assert glimpse is not None
    assert glimpse[1] == 3.0
    assert senses.glimpse(2.0) is None, "a scan is used once"


def test_a_driving_robot_asks_for_a_scan_even_if_a_query_is_pending() -> None:
    senses, _ = standing()
    assert [senses.look(now_s) for now_s in (0.0, 0.1)] == [[AskScan(MISSION.revolutions)]] * 2
