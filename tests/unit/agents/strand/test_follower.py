"""A follower's decisions: how far to drive, and whether the segment is clear."""

import math
from collections.abc import Iterator

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.navigation.sure import closer
from agents.strand.follower import DRIVE_M_MIN, RECHECK_S, Follower
from protocol.frames import Point, Pose
from protocol.mission import SEEN_SHARE, Mission
from protocol.path import THERE_M, Path
from protocol.timeline import SegmentChecked
from tests.support.stages.one_step import look_around, under
from tests.support.strategies.path_strategies import paths
from world.geometry.shapes import Circle, Shape

RADIUS_M = 0.1
MISSION = under("certified", robot_radius_m=RADIUS_M)
CLEAR_M = MISSION.epsilon_m - 2.0 * MISSION.mu0_m
NOBODY_M = 9.0  # beyond the path
AHEAD_M = 1.5  # where the robot ahead was last heard
SCAN_ERROR_M = (
    0.012  # 1440 directions are 11 mm apart at 2.5 m: the nearest point of a post may be between two
)
shares = st.floats(0.0, 1.0)


def bend() -> Path:
    """3 m to the right, then 2 m up."""
    return Path(Point(x_m=x_m, y_m=y_m) for x_m, y_m in [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0)])


def disc(x_m: float, y_m: float, radius_m: float = RADIUS_M) -> Shape:
    return Circle(centre_m=(x_m, y_m), radius_m=radius_m)


def fresh() -> Follower:
    return Follower(MISSION, start_m=0.0)


def looks(mission: Mission) -> Iterator[int]:
    """The revolutions of the first look and of ever closer ones."""
    revolutions: int | None = 1
    while revolutions is not None:
        yield revolutions
        revolutions = closer(mission, revolutions * mission.directions)


def check(
    follower: Follower,
    *shapes: Shape,
    progress_m: float = 0.0,
    behind_m: tuple[float, float] | None = None,
    ahead_m: float = AHEAD_M,
    now_s: float = 0.0,
    mission: Mission = MISSION,
) -> SegmentChecked:
    """Check the segment of the bend that begins where the follower stands."""
    path = bend()
    at = path.at(progress_m)
    pose = Pose(x_m=at.x_m, y_m=at.y_m, heading_rad=0.0)
    for revolutions in looks(mission):
        checked = follower.check(
            look_around(shapes, mission, pose, revolutions=revolutions),
            path,
            progress_m=progress_m,
            own_leg_m=0.0,
            robots=[path.between(ahead_m, path.end_m), *([path.between(*behind_m)] if behind_m else [])],
            now_s=now_s,
        )
        if isinstance(checked, SegmentChecked):
            return checked
    raise AssertionError("the closest look is not close enough")


def parts_m(follower: Follower, body: Shape) -> list[float]:
    """The parts of the first segment of the bend that it drives, one check after the other."""
    ends_m = [0.0]
    while ends_m[-1] < 3.0 and check(follower, body, progress_m=ends_m[-1], ahead_m=NOBODY_M).clear:
        ends_m.append(follower.clear_part_m(3.0))
    return ends_m


@given(paths(), shares, shares, st.floats(0.0, 1.2), st.booleans())
def test_a_follower_drives_neither_beyond_its_authority_nor_past_a_vertex(
    path: Path, progress: float, ordered: float, authority: float, final: bool
) -> None:
    progress_m, ordered_m = sorted((progress * path.end_m, ordered * path.end_m))
    authority_m = authority * path.end_m
    reach_m = fresh().reach_m(
        path, progress_m=progress_m, ordered_m=ordered_m, authority_m=authority_m, final=final
    )
    if reach_m is not None:
        vertices_m = [vertex.s_m for vertex in path.told_from(0, len(path))]
        assert ordered_m < reach_m <= authority_m
        assert not any(progress_m + THERE_M < vertex_m < reach_m for vertex_m in vertices_m)


def test_no_order_leads_round_a_corner_before_the_body_stands_there() -> None:
    """Where obstacles move, a scan from before the corner would permit the straight way to beyond it."""
    just_before_m = 3.0 - THERE_M / 2.0
    under_way, standing = (
        fresh().reach_m(bend(), progress_m=just_before_m, ordered_m=ordered_m, authority_m=5.0, final=False)
        for ordered_m in (3.0, just_before_m)
    )
    assert (under_way, standing) == (None, 5.0)


def test_a_follower_goes_no_further_by_one_order_than_a_scan_reaches() -> None:
    """S1: `mu0` covers the drive error of that length alone; a queue may be one long segment."""
    queue = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=20.0, y_m=0.0)])
    reach_m, follower = MISSION.range_m_max, fresh()
    for progress_m, ordered_m in [(1.0, 1.0), (2.0, 1.0 + reach_m)]:
        to_m = follower.reach_m(
            queue, progress_m=progress_m, ordered_m=ordered_m, authority_m=15.0, final=False
        )
        assert to_m == progress_m + reach_m


@given(paths(), st.lists(st.floats(0.001, 0.5), max_size=40))
def test_a_follower_reaches_its_authority_even_with_tiny_grants(path: Path, grants_m: list[float]) -> None:
    follower, progress_m, authority_m = fresh(), 0.0, 0.0
    for grant_m, final in [(grant_m, False) for grant_m in grants_m] + [(0.0, True)]:
        authority_m = min(authority_m + grant_m, path.end_m)
        for _ in range(len(path)):
            reach_m = follower.reach_m(
                path, progress_m=progress_m, ordered_m=progress_m, authority_m=authority_m, final=final
            )
            progress_m = progress_m if reach_m is None else reach_m
        assert authority_m - progress_m <= DRIVE_M_MIN
    assert authority_m - progress_m <= THERE_M


@pytest.mark.parametrize(
    ("authority_m", "final", "reach_m"),
    [
        (1.0 + 0.9 * DRIVE_M_MIN, False, None),
        (1.0 + 1.1 * DRIVE_M_MIN, False, 1.0 + 1.1 * DRIVE_M_MIN),
        (1.0 + 0.9 * DRIVE_M_MIN, True, 1.0 + 0.9 * DRIVE_M_MIN),
        (0.9, True, None),
        (9.0, False, 3.0),
    ],
)
def test_a_grant_too_small_to_be_worth_an_order_waits_unless_it_is_the_last(
    authority_m: float, final: bool, reach_m: float | None
) -> None:
    found_m = fresh().reach_m(bend(), progress_m=1.0, ordered_m=1.0, authority_m=authority_m, final=final)
    assert found_m == reach_m


def test_even_a_very_near_vertex_is_worth_an_order() -> None:
    found_m = fresh().reach_m(bend(), progress_m=2.99, ordered_m=2.99, authority_m=9.0, final=False)
    assert found_m == 3.0


def test_a_follower_on_its_way_to_its_authority_gets_no_new_order_until_that_grows() -> None:
    found_m = [
        fresh().reach_m(bend(), progress_m=1.0, ordered_m=2.0, authority_m=authority_m, final=False)
        for authority_m in (1.5, 2.0, 2.5)
    ]
    assert found_m == [None, None, 2.5]


def test_at_the_end_of_the_path_there_is_no_order() -> None:
    assert fresh().reach_m(bend(), progress_m=5.0, ordered_m=5.0, authority_m=9.0, final=True) is None


def test_each_segment_is_checked_once_and_is_then_clear_up_to_its_vertex() -> None:
    follower = fresh()
    before = [follower.is_clear(reach_m) for reach_m in (0.5, 3.0)]
    assert check(follower).clear
    after = [follower.is_clear(reach_m) for reach_m in (0.5, 3.0, 3.1, 5.0)]
    assert check(follower, progress_m=3.0).target == Point(x_m=3.0, y_m=2.0)
    later = [follower.is_clear(reach_m) for reach_m in (3.1, 5.0)]
    assert (before, after, later) == ([False, False], [True, True, False, False], [True, True])


def test_a_blocked_segment_is_checked_again_later_and_driven_when_it_is_clear() -> None:
    follower = fresh()
    assert follower.may_check(0.0)
    assert not check(follower, disc(1.0, 0.0), now_s=0.0).clear
    waited = [follower.may_check(now_s) for now_s in (0.1, 0.9 * RECHECK_S, RECHECK_S)]
    assert (waited, follower.is_clear(0.5)) == ([False, False, True], False)
    assert check(follower, now_s=RECHECK_S).clear
    assert follower.is_clear(3.0)


def test_after_a_clear_segment_the_next_may_be_checked_at_once() -> None:
    follower = fresh()
    check(follower, now_s=5.0)
    assert follower.may_check(5.0)


def test_robots_ahead_and_behind_on_the_path_are_no_obstacles() -> None:
    robots = disc(0.4, 0.0), disc(2.0, 0.0)
    checked = check(fresh(), *robots, progress_m=1.0, behind_m=(0.2, 0.5))
    assert checked.clear
    assert checked.clearance_m == MISSION.range_m_max - RADIUS_M


def test_a_hit_on_the_path_where_no_robot_may_be_is_an_obstacle() -> None:
    checked = check(fresh(), disc(1.0, 0.0))
    assert not checked.clear
    assert checked.clearance_m < 0.0


def test_a_body_on_the_way_to_where_the_robot_ahead_was_last_heard_is_an_obstacle() -> None:
    """V3 of the schedules: a robot dies on a leg that counts as driven."""
    body, robot_ahead = disc(1.0, 0.0), disc(2.0, 0.0)
    assert check(fresh(), robot_ahead, ahead_m=2.0).clear
    assert not check(fresh(), body, robot_ahead, ahead_m=2.0).clear


def test_a_body_on_the_path_behind_is_an_obstacle_where_the_robot_behind_cannot_be() -> None:
    """V22: a robot dies on a leg right behind; the robot behind is still farther back."""
    body = disc(0.75, 0.0)
    checked = check(fresh(), body, progress_m=1.0, behind_m=(0.0, 0.5))
    assert checked.clearance_m < MISSION.range_m_max - RADIUS_M
    checked = check(fresh(), body, progress_m=1.0, behind_m=(0.0, 0.75))
    assert checked.clearance_m == MISSION.range_m_max - RADIUS_M


def test_a_dead_robot_that_rolled_off_the_path_ahead_is_an_obstacle() -> None:
    off_m = RADIUS_M + 2.0 * MISSION.mu0_m
    assert not check(fresh(), disc(2.0, off_m)).clear


@given(st.floats(-0.5, 2.5), st.floats(-1.0, 1.0), st.floats(0.05, 0.3))
def test_a_segment_is_clear_if_a_post_beside_it_leaves_the_clearance(
    x_m: float, y_m: float, radius_m: float
) -> None:
    segment, post = shapely.LineString([(0.0, 0.0), (3.0, 0.0)]), shapely.Point(x_m, y_m)
    assume(post.distance(shapely.Point(0.0, 0.0)) > radius_m + RADIUS_M)
    clearance_m = segment.distance(post) - radius_m - RADIUS_M
    checked = check(fresh(), disc(x_m, y_m, radius_m), ahead_m=NOBODY_M)
    if clearance_m >= 0.0:
        # Only the side that faces the robot is seen: for a post far ahead, almost the nearest side.
        assert checked.clearance_m >= clearance_m - 1e-9
        assert checked.clear or clearance_m < CLEAR_M
    if clearance_m < CLEAR_M - SCAN_ERROR_M and x_m > SCAN_ERROR_M:
        assert not checked.clear


@given(st.floats(RADIUS_M + 0.01, RADIUS_M + MISSION.clear_m), st.floats(0.05, 0.3), st.floats(-0.99, 0.99))
def test_a_post_that_is_too_near_does_not_keep_the_robot_from_leaving(
    off_m: float, radius_m: float, aside: float
) -> None:
    sideways_rad = aside * math.acos(radius_m / (off_m + radius_m))  # the whole post is behind the robot
    x_m, y_m = -(off_m + radius_m) * math.cos(sideways_rad), (off_m + radius_m) * math.sin(sideways_rad)
    assert check(fresh(), disc(x_m, y_m, radius_m), ahead_m=NOBODY_M).clear


def test_a_post_that_is_too_near_does_not_hide_other_obstacles_on_the_way() -> None:
    behind = disc(-0.25, 0.0)
    checked = check(fresh(), behind, disc(1.5, 0.2), ahead_m=NOBODY_M)
    assert not checked.clear
    assert checked.clearance_m == pytest.approx(0.0, abs=SCAN_ERROR_M)


def test_a_robot_does_not_drive_past_a_post_that_is_too_near() -> None:
    assert not check(fresh(), disc(0.1, 0.24), ahead_m=NOBODY_M).clear


@pytest.mark.parametrize("law", ["printed", "resultant"])
def test_under_a_law_that_promises_nothing_followers_do_not_sense(law: str) -> None:
    assert Follower(under(law), start_m=0.0).is_clear(1000.0)


def test_in_a_new_formation_all_ground_is_looked_at_anew() -> None:
    follower = Follower(MISSION, start_m=2.0)
    assert [follower.is_clear(reach_m) for reach_m in (2.0, 2.1)] == [True, False]


@pytest.mark.parametrize(
    ("beyond_mu0", "some_are_left_out", "clear"),
    [(-1.5, False, True), (-0.7, True, False), (-0.3, True, True), (-2.5, False, False)],
)
def test_if_robots_are_left_out_the_whole_promise_must_be_seen_beside_driven_ground(
    beyond_mu0: float, *, some_are_left_out: bool, clear: bool
) -> None:
    follower = Follower(MISSION, start_m=0.0, some_are_left_out=some_are_left_out)
    gap_m = MISSION.clear_m + beyond_mu0 * MISSION.mu0_m
    body = disc(0.5, 2.0 * RADIUS_M + gap_m)
    assert (parts_m(follower, body)[-1] == 3.0) is clear


@given(off=st.floats(0.0, 4.0), separation_m=st.sampled_from([0.0, 0.15]))
def test_a_body_beside_granted_ground_is_passed_at_the_separation_whoever_it_is_taken_for(
    off: float, separation_m: float
) -> None:
    """F6 (b): in a hairpin, the least distance from ground that was granted to the robot behind."""
    mission = replace(MISSION, separation_m=separation_m, directions=7200)
    keep_m = mission.robot_keep_m
    corners = [(0.0, 0.0), (2.0, 0.0), (2.0, keep_m), (0.0, keep_m)]
    path = Path(Point(x_m=x_m, y_m=y_m) for x_m, y_m in corners)
    off_m = off * mission.mu0_m
    checked = Follower(mission, start_m=0.0, some_are_left_out=True).check(
        look_around([disc(1.0, off_m)], mission, Pose(x_m=2.0, y_m=keep_m, heading_rad=0.0)),
        path,
        progress_m=2.0 + keep_m,
        own_leg_m=0.0,
        robots=[path.between(0.0, 1.8)],
        now_s=0.0,
    )
    assert isinstance(checked, SegmentChecked)
    gap_m = math.hypot(max(0.0, checked.target.x_m - 1.0), keep_m - off_m) - 2.0 * RADIUS_M
    kept_m = min(mission.separation_m, mission.clear_m - SEEN_SHARE * mission.mu0_m)
    assert not checked.clear or gap_m >= kept_m - THERE_M


@given(
    along_m=st.floats(0.2, 3.0),
    gap_share=st.floats(0.5, 1.5),
    turned_rad=st.floats(0.0, math.tau),
    directions=st.sampled_from([180, 360, 1440]),
)
def test_no_body_that_is_left_out_is_passed_nearer_for_standing_between_two_rays(
    along_m: float, gap_share: float, turned_rad: float, directions: int
) -> None:
    """F6 (c)."""
    mission = replace(MISSION, directions=directions)
    follower = Follower(mission, start_m=0.0, some_are_left_out=True)
    beside_m = 2.0 * RADIUS_M + gap_share * mission.clear_m
    turn = np.array(
        [[math.cos(turned_rad), math.sin(turned_rad)], [-math.sin(turned_rad), math.cos(turned_rad)]]
    )
    (end_x_m, end_y_m), (x_m, y_m) = np.array([[3.0, 0.0], [along_m, beside_m]]) @ turn
    path = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=end_x_m, y_m=end_y_m)])
    for revolutions in looks(mission):
        seen = look_around([disc(x_m, y_m)], mission, revolutions=revolutions)
        checked = follower.check(seen, path, progress_m=0.0, own_leg_m=0.0, robots=[], now_s=0.0)
        if isinstance(checked, SegmentChecked) and checked.clear:
            ahead_m = along_m - math.hypot(checked.target.x_m, checked.target.y_m)
            gap_m = math.hypot(max(0.0, ahead_m), beside_m) - 2.0 * RADIUS_M
            assert gap_m >= mission.clear_m - SEEN_SHARE * mission.mu0_m - THERE_M


def test_of_a_segment_a_robot_drives_the_part_that_no_body_can_be_beside_and_looks_again_there() -> None:
    follower = Follower(MISSION, start_m=0.0, some_are_left_out=True)
    ends_m = parts_m(follower, disc(2.0, 2.0 * RADIUS_M + MISSION.clear_m - 0.45 * MISSION.mu0_m))
    assert len(ends_m) > 2
    assert ends_m == sorted(set(ends_m))
    assert ends_m[-1] == 3.0


@pytest.mark.parametrize("beside_m", [0.0, 0.15])
def test_a_body_beyond_the_range_is_met_by_a_check_that_sees_it(beside_m: float) -> None:
    """F6 (d): a robot dies as it crosses a leg that counts as driven and is longer than scans reach."""
    mission = replace(MISSION, range_m_max=1.5)
    follower, body = Follower(mission, start_m=0.0, some_are_left_out=True), disc(2.5, beside_m)
    at_m, clear = 0.0, True
    while clear and at_m < 3.0:
        clear = check(follower, body, progress_m=at_m, ahead_m=NOBODY_M, mission=mission).clear
        at_m = follower.clear_part_m(3.0) if clear else at_m
    assert not clear
    assert 0.5 < at_m <= 2.5 - 2.0 * RADIUS_M - mission.clear_m + mission.mu0_m
