"""Who has stayed on a strand's path keeps its place there, bends included, when all line up again."""

import numpy as np
import pytest
from agents.membership.berth import COASTS_S, Berth
from agents.membership.lining import Lining
from agents.membership.muster import Roster, folds_back, line_of
from agents.strand.forming import lined_up
from msgspec.structs import replace
from protocol.epochs import called_epoch

from agents.body.driver import Driver
from agents.commands import Announce
from protocol.frames import Point, Pose
from protocol.mission import Law
from protocol.path import Path
from protocol.wire.messages import FIRST_ATTEMPT, LEG_CORNERS_MAX, Attempt, Former, Muster, Odometry, Phase
from tests.support.stages.one_step import under

SPEED_MPS = 0.5
CORNER = Point(x_m=2.0, y_m=0.0)
LEAST_M = 0.3
GOAL = Point(x_m=2.0, y_m=9.0)
EPOCH = called_epoch(0, 1, 0.0)


def bend() -> Path:
    """2 m to the right, then 2 m up."""
    return Path([Point(x_m=0.0, y_m=0.0), CORNER, Point(x_m=2.0, y_m=2.0)])


def left_at(progress_m: float) -> Berth:
    return Berth(epoch=3, rank=1, progress_m=progress_m, path=bend(), speed_mps=SPEED_MPS)


def at(x_m: float, y_m: float) -> Pose:
    return Pose(x_m=x_m, y_m=y_m, heading_rad=0.0)


# --- where it stands --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("stands", "progress_m"),
    [
        (at(1.5, 0.0), 1.5),
        (at(1.9, 0.0), 1.9),
        (at(2.0, 0.3), 2.3),  # round the corner
        (at(2.01, 0.3), 2.3),  # off the path by what a drive may be off
        (at(1.2, 0.0), 1.5),  # nobody goes back
        (at(2.0, 2.0), 1.5 + COASTS_S * SPEED_MPS),  # nor further than it can have come
    ],
)
def test_where_a_robot_has_come_to_stand_is_on_the_path_a_little_beyond_where_it_left_it(
    stands: Pose, progress_m: float
) -> None:
    former = left_at(1.5).former(stands)
    assert (former.epoch, former.rank) == (3, 1)
    assert former.progress_m == pytest.approx(progress_m)


def test_at_the_end_of_what_it_knows_of_the_path_it_stands_there() -> None:
    assert left_at(4.0).former(at(2.0, 2.0)).progress_m == 4.0


@pytest.mark.parametrize(
    ("from_m", "to_m", "corners"),
    [(0.5, 1.5, ()), (0.5, 2.5, (CORNER,)), (2.0, 4.0, ()), (1.0, 2.0, ()), (1.0, 4.1, None)],
)
def test_the_way_to_the_robot_ahead_has_the_corners_between_the_two_if_it_is_known(
    from_m: float, to_m: float, corners: tuple[Point, ...] | None
) -> None:
    assert left_at(from_m).leg(from_m, to_m) == corners


def test_a_way_with_more_corners_than_can_be_said_is_none() -> None:
    zigzag = Path(Point(x_m=float(n), y_m=float(n % 2)) for n in range(LEG_CORNERS_MAX + 3))
    berth = Berth(epoch=3, rank=1, progress_m=0.0, path=zigzag, speed_mps=SPEED_MPS)
    assert berth.leg(0.0, zigzag[LEG_CORNERS_MAX + 1].s_m) is not None
    assert berth.leg(0.0, zigzag[LEG_CORNERS_MAX + 2].s_m) is None


# --- the order --------------------------------------------------------------------------------------

HAIRPIN = {4: at(0.0, 0.0), 3: at(1.0, 0.0), 2: at(1.0, 0.25), 1: at(0.0, 0.25)}  # the last leads
RANKS = {robot: Former(epoch=3, rank=robot - 1, progress_m=float(5 - robot)) for robot in HAIRPIN}


def muster(pose: Pose, former: Former | None, leg: tuple[Point, ...] = ()) -> Muster:
    return Muster(
        number=1, epoch=EPOCH, pose=pose, leg_clear=True, formers=() if former is None else (former,), leg=leg
    )


def roster(formers: dict[int, Former], attempt: Attempt = FIRST_ATTEMPT) -> Roster:
    made = Roster((1, 2, 3, 4), GOAL, LEAST_M, attempt)
    for robot, pose in HAIRPIN.items():
        made.hear(robot, muster(pose, formers.get(robot)))
    return made


def test_who_has_stayed_is_in_place_in_the_order_that_was_though_the_strand_folds_back() -> None:
    assert folds_back(HAIRPIN, (1, 2, 3, 4), least_m=LEAST_M)
    assert roster(RANKS).strand == (1, 2, 3, 4)


def test_without_a_place_in_a_strand_a_robot_comes_after_those_that_have_one() -> None:
    made = roster(
        {robot: former for robot, former in RANKS.items() if robot != 2}, attempt=Attempt(trial=False)
    )
    assert made.start_order == (1, 3, 4, 2)


BEFORE = {robot: Former(epoch=2, rank=robot - 1, progress_m=float(5 - robot)) for robot in (1, 2)}


def test_who_stands_nearer_to_the_front_of_those_who_have_stayed_leads_them_where_nobody_has_to_move() -> (
    None
):
    """Robot 1 led, was cut off, and is back; robot 2 has led two others since, and not moved."""
    others = {2: Former(epoch=3, rank=0, progress_m=2.0), 3: Former(epoch=3, rank=1, progress_m=1.0)}
    made = Roster((1, 2, 3), GOAL, LEAST_M)
    for robot, x_m in {1: 2.0, 2: 1.0, 3: 0.0}.items():
        formers = tuple(held[robot] for held in (others, BEFORE) if robot in held)
        made.hear(robot, replace(muster(at(x_m, 0.0), None), formers=formers))
    assert (made.in_front, made.strand, made.trial_failed) == ((1,), (1, 2, 3), False)
    assert made.stay(2, 1) == (BEFORE[2], BEFORE[1])


def test_where_somebody_would_have_to_move_for_that_the_order_is_the_one_that_was() -> None:
    stayed = {2: Former(epoch=3, rank=0, progress_m=2.0), 3: Former(epoch=3, rank=1, progress_m=1.0)}
    tried = []
    for attempt in (FIRST_ATTEMPT, Attempt(trial=False)):
        made = Roster((1, 2, 3), GOAL, LEAST_M, attempt)
        for robot, x_m in {1: 2.0, 2: 1.0, 3: 0.0}.items():
            made.hear(robot, replace(muster(at(x_m, 0.0), stayed.get(robot)), leg_clear=robot != 2))
        tried.append((made.start_order, made.trial_failed, made.next_attempt))
    assert tried == [
        ((1, 2, 3), True, Attempt(trial=False)),
        ((2, 3, 1), False, Attempt(trial=False, led=(2,))),
    ]


@pytest.mark.parametrize(
    "other",
    [
        Former(epoch=2, rank=1, progress_m=3.0),  # of another strand
        Former(epoch=3, rank=4, progress_m=3.0),  # with others between them
        Former(epoch=3, rank=1, progress_m=4.1),  # ahead of the one that is ahead
    ],
)
def test_who_did_not_stand_behind_another_in_its_strand_has_not_stayed_behind_it(other: Former) -> None:
    assert roster(RANKS).stay(2, 1) == (RANKS[2], RANKS[1])
    assert roster({**RANKS, 2: other}).stay(2, 1) is None


def test_the_way_of_a_strand_leads_over_the_corners_of_its_legs() -> None:
    places = {1: at(2.0, 2.0), 2: at(0.0, 0.0), 3: at(-1.0, 0.0)}
    line, leg = line_of(places, (1, 2, 3), {2: (CORNER,)})
    assert np.array_equal(line, [(2.0, 2.0), (2.0, 0.0), (0.0, 0.0), (-1.0, 0.0)])
    assert leg.tolist() == [0, 0, 1]


def test_the_strand_that_forms_measures_its_path_over_the_corners_of_its_legs() -> None:
    places, mission = {1: at(2.0, 2.0), 2: at(0.0, 0.0)}, under(Law.CERTIFIED, robots=2)
    strand = lined_up(2, (1, 2), places, mission, 0.0, legs={2: (CORNER,)}, driven=True)
    assert strand.path.end_m == pytest.approx(4.0)
    assert strand.own_leg_m == strand.start_m == 0.0, "the robot ahead has driven its leg"


# --- what a robot announces -------------------------------------------------------------------------


def lining_behind(former_ahead: Former) -> tuple[Lining, Driver]:
    """Robot 2, which stayed at 0.5 m, knows where robot 1 stands, at 3 m round the corner."""
    mission = under(Law.CERTIFIED, robots=2, robot_radius_m=0.1, goal=GOAL)
    lining = Lining(2, mission, 0.0, epoch=EPOCH, members=(1, 2), berths=(left_at(0.5),))
    lining.hear(1, replace(muster(at(2.0, 1.0), former_ahead), members=(1, 2)), 0.1)
    driver = Driver(speed_mps=SPEED_MPS)
    driver.hear(Odometry(t_s=0.1, pose=at(0.5, 0.0), moving=False, finished=0, phase=Phase.RUNNING))
    return lining, driver


def announced(lining: Lining, driver: Driver) -> Muster:
    (said,) = (command.muster for command in lining.act(driver, None, 0.1) if isinstance(command, Announce))
    assert isinstance(said, Muster)
    return said


def test_a_leg_round_a_bend_that_was_driven_is_clear_without_a_look() -> None:
    lining, driver = lining_behind(Former(epoch=3, rank=0, progress_m=3.0))
    said = announced(lining, driver)
    assert (said.leg_clear, said.leg) == (True, (CORNER,))
    assert not lining.wants_scan(driver)
    assert lining.order == (1, 2)
    assert lining.leg_is_driven


@pytest.mark.parametrize(
    "former", [Former(epoch=4, rank=0, progress_m=3.0), Former(epoch=3, rank=0, progress_m=0.4)]
)
def test_where_the_robot_ahead_has_not_stayed_ahead_it_looks(former: Former) -> None:
    lining, driver = lining_behind(former)
    said = announced(lining, driver)
    assert (said.leg_clear, said.leg) == (None, ())
    assert lining.wants_scan(driver)
