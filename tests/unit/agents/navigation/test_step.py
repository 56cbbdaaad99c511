"""The leader's decision on a scan: every case has its answer."""

import dataclasses
import math

import numpy as np
import pytest
from msgspec.structs import replace

from agents.navigation.certificate import certified_lengths_m, scan_walls, short_step_m
from agents.navigation.ground import Ground
from agents.navigation.step import GAIN_M, Crossed, NoStep
from agents.strand.dead_end import ROOM_STEPS_MAX
from agents.strand.leader import DeadEnd, Leader, Wait
from agents.strand.visited import AGAIN_MAX
from protocol.arrays import xy
from protocol.frames import METRES_MAX, Point, Pose
from protocol.mission import Bounds, Mission
from protocol.network.outbox import Outbox
from protocol.path import Path
from protocol.timeline import StepPlanned
from tests.support.stages.one_step import ORIGIN, Driven, alone, look_around, plan, step_through, under, wall
from world.geometry.shapes import Circle, Shape

ROBOT = under("certified", robot_radius_m=0.1)
KEEP_M = ROBOT.robot_radius_m + ROBOT.epsilon_m
BOUNDS = Bounds(x_m_min=-2.0, y_m_min=-5.0, x_m_max=12.0, y_m_max=5.0)


def to(x_m: float, y_m: float) -> Mission:
    return replace(ROBOT, goal=Point(x_m=x_m, y_m=y_m), goal_tolerance_m=0.2, bounds=BOUNDS)


def planned(answer: Driven | NoStep | Crossed) -> StepPlanned:
    assert isinstance(answer, Driven), answer
    return answer.planned


# --- with a goal ----------------------------------------------------------------------------------


def ring() -> list[Shape]:
    """Posts all around, with no way between them."""
    return [Circle(centre_m=(math.cos(0.3 * k), math.sin(0.3 * k)), radius_m=0.2) for k in range(21)]


def test_a_goal_in_the_open_is_one_step_away() -> None:
    step = planned(step_through([], to(3.0, 1.0)))
    assert (step.target.x_m, step.target.y_m) == pytest.approx((3.0, 1.0))
    assert step.cost_to_go_m == 0.0


def test_a_goal_beyond_the_range_is_approached_as_far_as_certified() -> None:
    step = planned(step_through([], to(10.0, 0.0)))
    assert ROBOT.range_m_max - KEEP_M - 0.1 < step.length_m < ROBOT.range_m_max - KEEP_M
    assert step.heading_rad == pytest.approx(0.0, abs=0.02)


def test_a_goal_that_is_further_away_than_a_message_can_tell_is_approached_too() -> None:
    step = planned(step_through([], replace(to(METRES_MAX, METRES_MAX), bounds=None)))
    assert step.length_m > KEEP_M
    assert step.cost_to_go_m == METRES_MAX


def test_with_a_goal_no_obstacle_and_one_obstacle_are_no_special_cases() -> None:
    post: list[Shape] = [Circle(centre_m=(1.5, 0.05), radius_m=0.3)]
    step = planned(step_through(post, to(3.0, 0.0)))
    assert step.length_m > 1.0
    assert step.heading_rad < 0.0, "around the post on the shorter side"


def test_a_leader_alone_goes_back_to_a_goal_behind_it() -> None:
    step = planned(step_through([], to(-1.5, 0.0)))
    assert abs(step.heading_rad) == pytest.approx(math.pi)


def queue_behind() -> Ground:
    """Robots behind occupy the x axis from -1 m to -0.3 m."""
    path = Path([Point(x_m=-1.0, y_m=0.0), Point(x_m=0.0, y_m=0.0)])
    return Ground(path, tail_m=0.0, granted_m=0.7, keep_m=0.3, behind_m=0.0)


def test_the_way_to_a_goal_behind_the_strand_avoids_granted_ground() -> None:
    mission = to(-1.5, 0.0)
    step = plan(Leader(mission, ORIGIN), [], mission, queue_behind())
    assert isinstance(step, StepPlanned)
    assert abs(step.target.y_m) >= 0.3
    assert step.cost_to_go_m is not None
    assert step.cost_to_go_m < 2.5, "around the queue, not away from it"


def test_if_only_the_strand_is_in_the_way_the_leader_waits_then_turns_it_round() -> None:
    mission = to(-1.5, 0.0)
    corridor: list[Shape] = [
        wall((-2.0, 0.3), (1.0, 0.3)),
        wall((1.0, -0.3), (-2.0, -0.3)),
        wall((1.0, 0.3), (1.0, -0.3)),
    ]
    answers = [
        plan(Leader(mission, ORIGIN), corridor, mission, queue_behind(), settled=settled)
        for settled in (False, True)
    ]
    assert answers == [Wait(), DeadEnd(back_to_m=None)]
    in_vain = plan(Leader(mission, ORIGIN), corridor, mission, queue_behind(), tail_may_lead=False)
    assert in_vain == DeadEnd(back_to_m=0.0), "the tail may have tried its way already"


def test_if_its_way_on_begins_between_it_and_the_tail_the_strand_backs_up_until_it_stands_there() -> None:
    mission = to(-0.7, 1.5)
    corridor: list[Shape] = [
        wall((-4.0, 0.3), (-1.1, 0.3)),
        wall((-0.3, 0.3), (0.3, 0.3)),
        wall((0.3, -0.3), (-4.0, -0.3)),
        wall((0.3, 0.3), (0.3, -0.3)),
    ]
    path = Path([Point(x_m=-2.2, y_m=0.0), Point(x_m=0.0, y_m=0.0)])
    queue = Ground(path, tail_m=1.2, granted_m=1.9, keep_m=0.3, behind_m=1.9)
    answer = plan(Leader(mission, ORIGIN), corridor, mission, queue)
    assert isinstance(answer, DeadEnd)
    assert answer.back_to_m is not None
    assert path.at(answer.back_to_m).x_m == pytest.approx(-0.6, abs=0.15), "below the gap"


def test_if_the_map_shows_no_way_from_where_the_tail_stands_the_strand_backs_up_to_where_it_does() -> None:
    """Found in a corridor that barely fits: noise of the scans had closed it in the map, behind the tail."""
    mission = to(-1.6, 1.5)
    corridor: list[Shape] = [
        wall((0.3, -0.3), (-2.0, -0.3)),
        wall((-1.3, 0.3), (0.3, 0.3)),
        wall((0.3, 0.3), (0.3, -0.3)),
        wall((-1.2, 0.3), (-1.2, 0.15)),
        wall((-1.2, -0.15), (-1.2, -0.3)),
    ]
    path = Path([Point(x_m=-1.8, y_m=0.0), Point(x_m=0.0, y_m=0.0)])
    queue = Ground(path, tail_m=1.2, granted_m=1.5, keep_m=0.3, behind_m=1.5)
    answer = plan(Leader(mission, ORIGIN), corridor, mission, queue)
    assert isinstance(answer, DeadEnd)
    assert answer.back_to_m is not None
    assert path.at(answer.back_to_m).x_m < -1.2, "beyond the spot that the map shows as closed"


def test_a_leader_alone_neither_waits_nor_turns_round() -> None:
    mission = to(3.0, 0.0)
    for settled in (False, True):
        assert isinstance(plan(Leader(mission, ORIGIN), ring(), mission, alone(), settled=settled), NoStep)


@pytest.mark.parametrize("may_forget", [True, False])
def test_a_leader_without_a_way_clears_its_map_if_it_may(*, may_forget: bool) -> None:
    leader, view = Leader(to(3.0, 0.0), ORIGIN), look_around(ring(), to(3.0, 0.0), ORIGIN)
    leader.plan(view, alone(), epoch=1, settled=True, bodies_may_move=True, may_forget=may_forget)
    assert leader.has_forgotten is may_forget
    assert (len(leader.map.hits) == 0) is may_forget


def test_a_leader_whose_steps_all_lead_back_to_one_place_reports_no_way() -> None:
    mission = to(3.0, 0.0)
    leader = Leader(mission, ORIGIN)
    answers = [plan(leader, [], mission, alone()) for _ in range(AGAIN_MAX + 1)]
    assert [isinstance(answer, StepPlanned) for answer in answers] == [True] * AGAIN_MAX + [False]
    assert isinstance(answers[-1], NoStep)


def test_a_leader_whose_steps_gain_the_minimum_goes_on() -> None:
    mission = to(3.0, 0.0)
    leader = Leader(mission, ORIGIN)
    for step in range(2 * AGAIN_MAX):
        at = Pose(x_m=step * GAIN_M, y_m=0.0, heading_rad=0.0)
        assert isinstance(plan(leader, [], mission, alone(at), at=at), StepPlanned)


def test_the_number_of_steps_that_free_no_ground_behind_is_limited() -> None:
    mission, ground = to(3.0, 0.0), queue_behind()
    leader, view = Leader(mission, ORIGIN), look_around([], mission, ORIGIN)

    def makes_room(ground: Ground) -> bool:
        return isinstance(leader.make_room(view, ground, epoch=1, room_m=0.5), StepPlanned)

    in_vain = [makes_room(ground) for _ in range(ROOM_STEPS_MAX + 1)]
    assert in_vain == [True] * ROOM_STEPS_MAX + [False]
    assert makes_room(dataclasses.replace(ground, granted_m=0.75))


@pytest.mark.parametrize("goal", [(0.0, 2.0), (1.0, -1.0), (0.5, 1.5)])
def test_a_step_keeps_off_granted_ground(goal: tuple[float, float]) -> None:
    mission = to(*goal)
    path = Path([Point(x_m=-1.0, y_m=0.5), Point(x_m=-0.3, y_m=0.5), Point(x_m=0.0, y_m=0.0)])
    ground = Ground(path, tail_m=0.0, granted_m=0.7, keep_m=0.55, behind_m=0.0)
    step = plan(Leader(mission, ORIGIN), [], mission, ground)
    assert isinstance(step, StepPlanned)
    granted = np.column_stack([np.linspace(-1.0, -0.3, 50), np.full(50, 0.5)])
    along = np.linspace(0.0, 1.0, 200)[:, None] * np.array([step.target.x_m, step.target.y_m])
    apart = np.hypot(*(along[:, None] - granted[None]).transpose(2, 0, 1))
    assert apart.min() >= 0.55 - 1e-9


def test_without_an_open_way_the_leader_reports_it_and_does_not_wander() -> None:
    answer = step_through(ring(), to(3.0, 0.0))
    assert answer == NoStep("no way to the goal is left in what is known")


def test_a_closed_goal_is_approached_within_its_tolerance() -> None:
    on_it: list[Shape] = [Circle(centre_m=(2.0, 0.0), radius_m=0.1)]
    mission = replace(to(2.0, 0.0), goal_tolerance_m=0.5)
    step = planned(step_through(on_it, mission))
    assert math.hypot(step.target.x_m - 2.0, step.target.y_m) < 0.5


def test_the_map_keeps_the_robot_out_of_a_pocket_that_it_has_seen() -> None:
    pocket: list[Shape] = [
        wall((2.0, -1.0), (2.0, 1.0)),
        wall((2.0, 1.0), (0.8, 1.0)),
        wall((0.8, -1.0), (2.0, -1.0)),
    ]
    step = planned(step_through(pocket, to(4.0, 0.0)))
    inside = 0.8 < step.target.x_m < 2.0 and abs(step.target.y_m) < 1.0
    assert not inside


# --- without a goal -------------------------------------------------------------------------------


def test_without_a_goal_the_widest_passable_gap_is_approached() -> None:
    # From right to left: a gap of 0.5 m, then one of 1.2 m.
    posts: list[Shape] = [Circle(centre_m=(2.0, y_m), radius_m=0.1) for y_m in (-1.2, -0.5, 0.9)]
    step = planned(step_through(posts, ROBOT))
    assert step.gap is not None
    assert step.gaps[step.gap].width_m == pytest.approx(1.2, abs=0.05)
    assert step.target.y_m == pytest.approx(0.2, abs=0.1)


def test_the_leader_drives_around_a_gap_that_is_too_narrow() -> None:
    posts: list[Shape] = [Circle(centre_m=(2.0, y_m), radius_m=0.1) for y_m in (-0.29, 0.29)]
    step = planned(step_through(posts, ROBOT))
    assert step.gap is None
    assert step.target.x_m > 2.0
    assert abs(step.target.y_m) > 0.29 + 0.1 + KEEP_M


def test_if_every_gap_ahead_is_too_narrow_there_is_no_step() -> None:
    slit: list[Shape] = [wall((0.202, 8.0), (0.202, 0.05)), wall((0.202, -0.05), (0.202, -8.0))]
    answer = step_through(slit, ROBOT)
    assert isinstance(answer, NoStep)
    assert "onward" in answer.reason


@pytest.mark.parametrize("shapes", [[], [Circle(centre_m=(1.0, 0.5), radius_m=0.2)]])
def test_without_a_goal_an_open_way_and_no_gap_ahead_mean_that_the_region_is_crossed(
    shapes: list[Shape],
) -> None:
    assert step_through(shapes, ROBOT) == Crossed()


def test_the_leader_drives_around_one_obstacle_in_the_way_onward() -> None:
    post: list[Shape] = [Circle(centre_m=(1.5, 0.05), radius_m=0.3)]
    step = planned(step_through(post, ROBOT))
    assert step.target.x_m > 1.5


def test_the_leader_does_not_go_back_to_a_gap_behind() -> None:
    posts: list[Shape] = [Circle(centre_m=(-2.0, y_m), radius_m=0.1) for y_m in (-0.6, 0.6)]
    assert step_through(posts, ROBOT) == Crossed()
    facing_it = Pose(x_m=0.0, y_m=0.0, heading_rad=math.pi)
    assert isinstance(step_through(posts, ROBOT, facing_it), Driven)


# --- where one place is not enough to look from ---------------------------------------------------

SHARP = replace(
    to(10.0, 0.0), directions=360, range_error_m_max=0.0015, sharpest_corner_rad=math.radians(1.0)
)
"""A corner of 1 degree somewhere: the closest look may miss 10.6 mm beside the wall of a narrow corridor."""


def corridor(*, half_m: float) -> list[Shape]:
    return [wall((-3.0, half_m), (3.0, half_m)), wall((3.0, -half_m), (-3.0, -half_m))]


def test_a_short_step_leads_to_a_second_place_to_look_from_and_only_there() -> None:
    leader, walls = Leader(SHARP, ORIGIN), corridor(half_m=0.212)
    first = plan(leader, walls, SHARP, alone())
    assert isinstance(first, StepPlanned)
    assert first.length_m == pytest.approx(short_step_m(SHARP))
    there = Pose(x_m=first.target.x_m, y_m=first.target.y_m, heading_rad=0.0)
    again = plan(leader, walls, SHARP, alone(there), at=there)
    assert isinstance(again, StepPlanned)
    certified = scan_walls(look_around(walls, SHARP, there, revolutions=20), SHARP)
    ahead_m = float(certified_lengths_m(xy(there), np.array([again.heading_rad]), certified)[0])
    assert ahead_m < GAIN_M, "alone, the second scan shows no way either"


@pytest.mark.parametrize("settings", [{"bodies_may_move": True}, {}])
def test_no_short_step_is_planned_where_bodies_may_move_or_a_wall_is_too_near(
    settings: dict[str, bool],
) -> None:
    half_m = 0.212 if settings else 0.1999
    seen = look_around(corridor(half_m=half_m), SHARP, revolutions=20)
    answer = Leader(SHARP, ORIGIN).plan(seen, alone(), epoch=1, settled=True, **settings)
    assert isinstance(answer, NoStep)


# --- the record -----------------------------------------------------------------------------------


def test_a_plan_records_what_was_seen_and_chosen() -> None:
    posts: list[Shape] = [Circle(centre_m=(2.0, y_m), radius_m=0.1) for y_m in (-0.6, 0.6)]
    step = planned(step_through(posts, ROBOT))
    assert len(step.obstacles) == len(step.gaps) == 2
    assert [gap.passable for gap in step.gaps] == [True, False], "the second opens away from the robot"
    assert step.reach_m == step.length_m
    assert step.promised_clearance_m is not None
    assert step.promised_clearance_m >= ROBOT.epsilon_m - 1e-9


def test_the_last_switching_position_is_the_requested_one() -> None:
    leader = Leader(replace(ROBOT, switching_positions_max=2), ORIGIN)
    posts: list[Shape] = [Circle(centre_m=(2.0, y_m), radius_m=0.1) for y_m in (-0.6, 0.6)]
    assert not leader.is_done(np.zeros(2))
    assert isinstance(plan(leader, posts, ROBOT, alone()), StepPlanned)
    assert leader.is_done(np.zeros(2))


def test_a_promise_covers_obstacles_but_not_the_robot_behind() -> None:
    path = Path([Point(x_m=-0.27, y_m=0.0), Point(x_m=0.0, y_m=0.0)])
    ground = Ground(path, tail_m=0.0, granted_m=0.0, keep_m=0.26, behind_m=0.0)
    robot_behind: list[Shape] = [Circle(centre_m=(-0.27, 0.0), radius_m=0.1)]
    step = plan(Leader(to(3.0, 0.0), ORIGIN), robot_behind, ROBOT, ground)
    assert isinstance(step, StepPlanned)
    assert step.promised_clearance_m is not None
    assert step.promised_clearance_m >= ROBOT.epsilon_m


def test_a_plan_with_many_obstacles_still_fits_into_a_message() -> None:
    finest = replace(ROBOT, directions=7200, robot_radius_m=0.0, epsilon_m=0.001)
    pickets: list[Shape] = [
        Circle(centre_m=(2.0 * math.cos(0.01 * k), 2.0 * math.sin(0.01 * k)), radius_m=0.004)
        for k in range(620)
    ]
    step = planned(step_through(pickets, finest))
    assert len(step.obstacles) == len(step.gaps) == 250
    outbox = Outbox()
    outbox.add(step, t_s=0.0, hlc="")
    assert outbox.batch(0.0) is not None
