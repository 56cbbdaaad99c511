"""How much of its path a strand that backs up takes along."""

import pytest

from agents.strand.dead_end import cut_before_m
from agents.strand.grants import GRANT_M_MIN
from agents.strand.leader import DeadEnd, Leader
from protocol.frames import Point
from protocol.path import Path
from tests.support.stages.member_stage import MemberStage, row
from tests.support.stages.one_step import under

ROBOTS = 5
MISSION = under(
    "certified", robots=ROBOTS, robot_radius_m=0.1, separation_m=0.1, goal=Point(x_m=6.0, y_m=0.0)
)
BACK_BY_M = 0.6
STRAND_M = (ROBOTS - 1) * MISSION.grant_keep_m + 0.1  # closed up, but for a little


def path(*corners: tuple[float, float]) -> Path:
    return Path(Point(x_m=x_m, y_m=y_m) for x_m, y_m in corners)


def cut(way: Path, back_by_m: float) -> float:
    tail_m = way.end_m - STRAND_M
    return cut_before_m(way, MISSION, robots=ROBOTS, tail_m=tail_m, back_by_m=back_by_m)


@pytest.mark.parametrize("back_by_m", [0.1, 1.0, 5.0])
def test_on_a_straight_path_the_first_robot_goes_back_little_further_than_the_leader(
    back_by_m: float,
) -> None:
    way = path((0.0, 0.0), (20.0, 0.0))
    further_m = way.end_m - STRAND_M - cut(way, back_by_m) - back_by_m
    assert 0.0 <= further_m <= ROBOTS * GRANT_M_MIN + 1e-9


@pytest.mark.parametrize("back_by_m", [1.0, 8.0])
def test_a_strand_that_need_not_go_back_where_its_path_crosses_itself_does_not(back_by_m: float) -> None:
    loop = path(
        (0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 4.0), (2.0, -8.0)
    )  # it crosses itself at 2 and 14 m
    assert 2.0 + MISSION.grant_keep_m < cut(loop, back_by_m) < loop.end_m - STRAND_M - back_by_m


def test_where_the_path_bends_sharply_behind_the_tail_the_first_robot_goes_back_further() -> None:
    """Between the sides of a hairpin robots need more of the path than they take up on a straight one."""
    near_m = 0.5 * MISSION.grant_keep_m
    hairpin = path((0.0, near_m), (10.0, near_m), (10.0, 0.0), (8.0, 0.0))
    straight = path((-2.0 - near_m, 0.0), (10.0, 0.0))
    assert hairpin.end_m == pytest.approx(straight.end_m)
    assert 0.0 < cut(hairpin, 1.0) < cut(straight, 1.0) - 0.5


def test_where_corners_lie_between_robots_the_first_one_goes_back_further() -> None:
    """A robot is granted up to `GRANT_M_MIN` less than is free, so there is little to spare for corners."""
    corners = path((0.0, 0.0), (10.0, 0.0), (10.0, 1.0), (10.6, 1.0), (10.6, 2.0))
    straight = path((0.0, 0.0), (corners.end_m, 0.0))
    assert 0.0 < cut(corners, 0.3) < cut(straight, 0.3)


def test_a_path_that_is_too_short_is_taken_along_to_its_beginning() -> None:
    assert cut(path((0.0, 0.0), (STRAND_M + 1.0, 0.0)), 1.0) == 0.0


def test_a_strand_backs_up_as_far_as_its_leader_needs_and_its_first_robot_little_further(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stage = MemberStage(MISSION, row(ROBOTS, spacing_m=0.36), tuple(range(1, ROBOTS + 1)))
    stage.run(10.0)  # the leader is on its way, with metres of path behind the tail when it comes to its end
    monkeypatch.setattr(Leader, "plan", lambda *_, **__: DeadEnd(stage.leader.progress_m - BACK_BY_M))
    stage.run(15.0)
    reason = stage.leader.reason
    assert reason is not None
    assert reason.turnabout is not None
    end_m, tail_m = stage.leader.progress_m, stage.members[ROBOTS].progress_m
    assert tail_m > 1.0 + BACK_BY_M
    stage.reform(reason.turnabout)
    stage.run(25.0)
    reason = stage.leader.reason
    assert reason is not None
    assert reason.why == "the tail has come back far enough"
    assert end_m - tail_m + BACK_BY_M < stage.leader.path.end_m < end_m - 1.0, (
        "little of the path is taken along"
    )
