"""A robot and its sensor: queries, repetitions, and the answers that are accepted."""

import pytest
from msgspec.structs import replace

from agents.body.driver import Driver
from agents.body.senses import MADE_UP_MAX, RETRY_S, Senses
from agents.commands import AskScan
from protocol.fence import Epoch, Fence, May
from protocol.frames import Pose
from protocol.mission import RAYS_MAX
from protocol.wire.messages import Odometry, Phase, Scan
from tests.support.stages.one_step import under

MISSION = under("certified", directions=8, revolutions=2)
FENCE = Fence(epoch=Epoch(generation=3, robot=1, life=7), turn=4, may=May.ALL)
HERE, THERE = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), Pose(x_m=1.0, y_m=0.0, heading_rad=0.0)


def odometry(n: int, at: Pose, fence: Fence = FENCE) -> Odometry:
    return Odometry(n=n, t_s=0.0, pose=at, moving=False, finished=0, fence=fence, phase=Phase.RUNNING)


def standing(at: Pose = HERE) -> tuple[Senses, Driver]:
    driver = Driver(speed_mps=MISSION.speed_mps)
    driver.hear(odometry(1, at))
    return Senses(MISSION, driver), driver


def scan(
    at: Pose = HERE,
    *,
    t_s: float = 0.0,
    revolutions: int = 2,
    range_m: float = 9.0,
    fence: Fence = FENCE,
) -> Scan:
    return Scan(t_s=t_s, pose=at, fence=fence, ranges_m=(range_m,) * (revolutions * MISSION.directions))


def test_a_query_is_repeated_only_if_no_answer_has_come_for_a_while() -> None:
    senses, _ = standing()
    asked = [senses.ask(now_s) for now_s in (0.0, 0.9 * RETRY_S, RETRY_S)]
    assert asked == [[AskScan(MISSION.revolutions)], [], [AskScan(MISSION.revolutions)]]


def test_a_robot_that_hears_little_makes_up_for_the_queries_that_it_would_have_repeated() -> None:
    senses, _ = standing()
    asked = [len(senses.ask(now_s)) for now_s in (0.0, 3.5 * RETRY_S, 9.0)]
    assert asked == [1, 3, MADE_UP_MAX]
    senses.hear(scan(THERE))
    assert len(senses.ask(20.0)) == 1, "the last query has been answered, if too late"
    senses.forget()
    assert len(senses.ask(30.0)) == 1, "in another view it asks anew"


def test_a_closer_look_is_one_scan_with_four_times_the_revolutions() -> None:
    senses, _ = standing()
    senses.hear(scan(revolutions=MISSION.revolutions))
    seen = senses.take()
    assert seen is not None
    assert senses.look_closer(seen)
    assert senses.ask(0.0) == [AskScan(4 * MISSION.revolutions)]
    senses.hear(scan(revolutions=4 * MISSION.revolutions))
    assert senses.take() is not None
    assert senses.ask(0.0) == [AskScan(MISSION.revolutions)], "the next one is as usual"


def test_there_is_no_closer_look_than_one_that_fills_a_message() -> None:
    senses, _ = standing()
    senses.hear(scan(revolutions=RAYS_MAX // MISSION.directions))
    seen = senses.take()
    assert seen is not None
    assert not senses.look_closer(seen)
    assert senses.ask(0.0) == [AskScan(MISSION.revolutions)]


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
    driver.hear(odometry(2, THERE))
    assert senses.take() is None


OTHERS = [
    replace(FENCE, turn=3),
    replace(FENCE, turn=5),
    replace(FENCE, epoch=replace(FENCE.epoch, generation=2)),
    replace(FENCE, epoch=replace(FENCE.epoch, life=8)),
]


@pytest.mark.parametrize("other", OTHERS)
def test_a_scan_serves_only_under_the_very_fence_that_it_bears(other: Fence) -> None:
    """V4 of the schedules: a leg is looked at, another robot has a turn and stops on it."""
    senses, _ = standing()
    senses.hear(scan(fence=other))
    assert senses.take() is None
    senses.hear(scan(fence=other, t_s=3.0))
    assert senses.glimpse(2.0) is None


def test_a_scan_is_void_once_odometry_tells_another_fence() -> None:
    senses, driver = standing()
    senses.hear(scan())
    driver.hear(odometry(1, HERE, replace(FENCE, turn=5)))
    assert senses.take() is None


def test_a_scan_is_void_under_a_fence_that_is_not_in_force(monkeypatch: pytest.MonkeyPatch) -> None:
    senses, _ = standing()
    monkeypatch.setattr("agents.body.senses.in_force", lambda _: False)
    senses.hear(scan())
    assert senses.take() is None


def test_a_scan_with_too_few_revolutions_is_a_late_answer_to_another_query() -> None:
    senses, _ = standing()
    senses.hear(scan(revolutions=MISSION.revolutions))
    seen = senses.take()
    assert seen is not None
    senses.look_closer(seen)
    senses.hear(scan(revolutions=MISSION.revolutions))
    assert senses.take() is None
    senses.hear(scan(revolutions=4 * MISSION.revolutions))
    assert senses.take() is not None


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
