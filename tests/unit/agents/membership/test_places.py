"""A robot that has stayed on a strand's path keeps its place there, corners included."""

from types import SimpleNamespace
from typing import cast

import pytest

from agents.membership.places import COASTS_M, OldPlace, Past
from agents.strand.member import Member
from protocol.fence import Epoch
from protocol.frames import Point, Pose
from protocol.path import Path
from protocol.wire.view import FORMERS_MAX, LEG_CORNERS_MAX, Counters, Former
from tests.support.stages.member_stage import MemberStage, row
from tests.support.stages.one_step import under
from world.geometry.shapes import Circle

CORNER, AHEAD = Point(x_m=2.0, y_m=0.0), Point(x_m=2.0, y_m=1.0)
LEG = (Point(x_m=0.5, y_m=0.0), CORNER, AHEAD)
EPOCH = Epoch(generation=3, robot=1, life=7)
BEFORE = Epoch(generation=2, robot=2, life=8)


def bend() -> Path:
    """2 m to the right, then 2 m up."""
    return Path([Point(x_m=0.0, y_m=0.0), CORNER, Point(x_m=2.0, y_m=2.0)])


def left_at(progress_m: float, *, epoch: Epoch = EPOCH, path: Path | None = None) -> OldPlace:
    return OldPlace(epoch=epoch, rank=1, progress_m=progress_m, path=path or bend())


def ended(place: OldPlace, *, moved: bool = False, fits: bool = True) -> Member:
    """A member of a strand that has ended, which left it at this place."""
    member = SimpleNamespace(
        formation=place,
        strand=SimpleNamespace(behind_m=place.behind_m, neighbours={}),
        progress_m=place.progress_m,
        path=place.path,
        has_moved=moved,
        fits=fits,
        counters=Counters(),
        arrived=False,
    )
    return cast("Member", member)


def at(x_m: float, y_m: float) -> Pose:
    return Pose(x_m=x_m, y_m=y_m, heading_rad=0.0)


def ahead_at(
    s_m: float,
    *,
    epoch: Epoch = EPOCH,
    rank: int = 0,
    leg_from_m: float | None = 0.5,
) -> tuple[Former, ...]:
    from_m = s_m if leg_from_m is None else leg_from_m
    corners = tuple(vertex for vertex in bend() if from_m < vertex.s_m < s_m)
    place = bend().at(s_m)
    former = Former(epoch=epoch, rank=rank, s_m=s_m, at=place, leg_from_m=leg_from_m, corners=corners)
    return (former,)


def leg_of(
    past: Past, ahead: tuple[Former, ...], stands: Pose, ahead_stands: Pose | None = None
) -> tuple[Point, ...] | None:
    """The leg to a robot ahead that stands on its path, or there."""
    return past.leg_to(ahead, stands, ahead_stands or at(2.0, 1.0), off_m_max=0.02)


# --- where it stands --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stands", "s_m"),
    [
        (at(1.5, 0.0), 1.5),
        (at(1.9, 0.0), 1.9),
        (at(2.0, 0.3), 2.3),  # round the corner
        (at(2.01, 0.3), 2.3),  # off the path by what a drive may be off
        (at(1.2, 0.0), 1.5),  # nobody goes back
        (at(2.0, 2.0), 1.5 + COASTS_M),  # nor further than it can have come
    ],
)
def test_where_a_robot_stands_is_on_the_path_a_little_beyond_where_it_left_it(
    stands: Pose, s_m: float
) -> None:
    former = left_at(1.5).former(stands)
    assert (former.epoch, former.rank, former.draft) == (EPOCH, 1, False)
    assert former.s_m == pytest.approx(s_m)


def test_at_the_end_of_what_it_knows_of_the_path_it_stands_there() -> None:
    assert left_at(4.0).former(at(2.0, 2.0)).s_m == 4.0


@pytest.mark.parametrize(
    ("behind_m", "stands", "corners"),
    [
        (0.5, at(1.5, 0.0), ()),
        (0.5, at(2.0, 0.5), (CORNER,)),
        (2.0, at(2.0, 1.0), ()),
        (1.0, at(2.0, 0.0), ()),
        (None, at(2.0, 0.5), None),
    ],
)
def test_a_robot_tells_the_corners_of_the_path_between_it_and_the_robot_behind(
    behind_m: float | None, stands: Pose, corners: tuple[Point, ...] | None
) -> None:
    former = OldPlace(EPOCH, 0, 1.4, bend(), behind_m=behind_m).former(stands)
    assert former.leg_from_m == behind_m
    assert tuple(Point(x_m=each.x_m, y_m=each.y_m) for each in former.corners) == (corners or ())


@pytest.mark.parametrize(("corners", "told"), [(LEG_CORNERS_MAX, True), (LEG_CORNERS_MAX + 1, False)])
def test_a_way_with_more_corners_than_can_be_told_is_not_told(corners: int, told: bool) -> None:
    zigzag = Path(Point(x_m=float(n), y_m=float(n % 2)) for n in range(corners + 2))
    end = zigzag[corners + 1]
    former = OldPlace(EPOCH, 0, end.s_m, zigzag, behind_m=0.0).former(at(end.x_m, end.y_m))
    assert (former.leg_from_m == 0.0, len(former.corners) > 0) == (told, told)


# --- driven legs ------------------------------------------------------------------------------------


def test_a_leg_is_driven_if_both_stand_on_one_path_one_behind_the_other() -> None:
    past = Past((left_at(0.5),))
    assert leg_of(past, ahead_at(3.0), at(0.5, 0.0)) == LEG


def test_a_robot_that_was_cut_off_learns_the_way_from_the_robot_that_has_driven_it() -> None:
    known = Path([Point(x_m=0.0, y_m=0.0), Point(x_m=1.0, y_m=0.0)])
    assert leg_of(Past((left_at(0.5, path=known),)), ahead_at(3.0), at(0.5, 0.0)) == LEG


def test_a_leg_is_laid_where_it_was_and_not_from_where_bodies_stand_beside_it() -> None:
    past = Past((left_at(0.5),))
    assert leg_of(past, ahead_at(3.0), at(0.5, -0.01), at(2.01, 1.0)) == LEG


@pytest.mark.parametrize(
    ("stands", "ahead_stands"),
    [
        (at(0.5, -0.3), None),  # a second process has moved its body while this one was stopped
        (at(0.45, 0.0), None),  # after a power cut the world may put a body back
        (at(0.5, 0.0), at(2.0, 1.05)),
    ],
)
def test_no_leg_was_driven_from_or_to_where_a_robot_stands_beside_its_place(
    stands: Pose, ahead_stands: Pose | None
) -> None:
    assert leg_of(Past((left_at(0.5),)), ahead_at(3.0), stands, ahead_stands) is None


def test_corners_that_the_robot_behind_has_passed_are_not_in_its_leg() -> None:
    assert leg_of(Past((left_at(2.5),)), ahead_at(3.0), at(2.0, 0.5)) == (Point(x_m=2.0, y_m=0.5), AHEAD)


@pytest.mark.parametrize(
    "ahead",
    [
        ahead_at(3.0, epoch=BEFORE),  # V23: places on the paths of two epochs
        ahead_at(3.0, epoch=Epoch(generation=3, robot=1, life=9)),  # of another life's epoch
        ahead_at(3.0, rank=2),  # not the next ahead
        ahead_at(0.4),  # behind it on the path
        ahead_at(3.0, leg_from_m=None),  # that robot tells no corners
        ahead_at(3.0, leg_from_m=0.6),  # it tells the corners of a part
        (Former(epoch=EPOCH, rank=0),),  # nobody has driven to a place in a draft
        (),
    ],
)
def test_v23_a_leg_between_places_of_two_epochs_or_that_is_not_known_was_not_driven(
    ahead: tuple[Former, ...],
) -> None:
    assert leg_of(Past((left_at(0.5),)), ahead, at(0.5, 0.0)) is None


def test_a_leg_of_an_earlier_strand_counts_for_robots_that_have_not_moved_since() -> None:
    past = Past((left_at(0.5, epoch=BEFORE),)).with_strand(ended(left_at(0.5)))
    assert leg_of(past, ahead_at(3.0, epoch=BEFORE), at(0.5, 0.0)) == LEG


# --- which places it has ------------------------------------------------------------------------------


def test_a_robot_that_has_moved_in_a_strand_has_left_its_older_places() -> None:
    past = Past((left_at(0.5, epoch=BEFORE),))
    assert [
        former.epoch for former in past.with_strand(ended(left_at(1.0), moved=True)).formers(at(1.0, 0.0))
    ] == [EPOCH]


def test_no_more_places_are_told_than_a_report_holds() -> None:
    past = Past()
    for generation in range(6):
        epoch = Epoch(generation=generation, robot=1, life=7)
        past = past.with_strand(ended(left_at(0.5, epoch=epoch)))
    past = past.with_draft(EPOCH, 2)
    told = past.formers(at(0.5, 0.0))
    assert len(told) == FORMERS_MAX
    assert [(former.epoch.generation, former.draft) for former in told] == [
        (3, True),
        (5, False),
        (4, False),
        (3, False),
    ]


def test_a_place_in_a_draft_is_kept_until_that_draft_has_it_no_more() -> None:
    past = Past().with_draft(EPOCH, 2)
    assert past.with_draft(BEFORE, None) == past, "another view tells nothing of it"
    assert past.with_draft(EPOCH, None) == Past()
    assert past.with_draft(EPOCH, 1).formers(at(0.0, 0.0))[0].rank == 1


def test_a_strand_that_forms_ends_the_place_in_its_draft() -> None:
    assert Past().with_draft(EPOCH, 2).with_strand(ended(left_at(0.5))).draft is None


def test_a_robot_that_did_not_stand_at_its_place_in_a_strand_has_no_place() -> None:
    assert Past((left_at(0.5, epoch=BEFORE),)).with_strand(ended(left_at(0.5), fits=False)).places == ()


@pytest.mark.parametrize(("off_m", "is_driven"), [(-0.9, False), (1.0, True)])
def test_a_leader_that_began_too_near_to_something_tells_no_driven_leg(
    off_m: float, *, is_driven: bool
) -> None:
    """That leg leads through where it began, to which nobody may come; nobody but the leader has left it."""
    mission = under("certified", robots=3, robot_radius_m=0.1, separation_m=0.1, goal=Point(x_m=6.0, y_m=0.0))
    beside_m = mission.robot_radius_m + mission.clear_m + off_m * mission.mu0_m + 0.1
    stage = MemberStage(mission, row(3), (1, 2, 3), shapes=[Circle(centre_m=(0.0, beside_m), radius_m=0.1)])
    stage.run(30.0)
    leader = stage.leader
    assert leader.progress_m > leader.formation.s_m + 0.5
    (former,) = Past().with_strand(leader).formers(stage.parts[1].driver.odometry.pose)
    assert (former.leg_from_m is not None) == is_driven
