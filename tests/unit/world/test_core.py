import pytest

from protocol.exit_codes import ExitCode
from protocol.frames import Point
from protocol.mission import start_wall_s
from protocol.process.tokens import TokenCame, TokenWent
from protocol.timeline import (
    BodyStopped,
    MessageRefused,
    OrderAccepted,
    OrderFinished,
    PoseSampled,
    PromiseBroken,
    RobotAppeared,
    RobotArrived,
    RobotSettled,
    RouteLost,
    RunEnded,
    ScanServed,
    StepFinished,
    TrafficCounted,
)
from protocol.wire.messages import Drive, Phase
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage, planned
from world.bodies.arena import ODOMETRY_TICKS, TICK_S
from world.core import LAST_WORDS_WALL_S
from world.events import MessageDropped, OrderHeard, ScanAsked, StopAsked
from world.judge.ending import Ending

AHEAD = Point(x_m=0.5, y_m=0.0)
FAR = Point(x_m=-3.0, y_m=0.0)
SECOND = round(1.0 / TICK_S)


def running(**sections: dict[str, object]) -> Stage:
    stage = Stage(scenario(**sections))
    stage.begin()
    return stage


def kinds(records: object) -> list[str]:
    assert isinstance(records, list)
    return [type(record).__name__ for record in records]


def test_the_clock_starts_when_all_robots_have_come() -> None:
    stage = Stage(scenario())
    assert stage.handle(TokenCame(2, "a")) == [RobotAppeared(robot=2, incarnation="a")]
    assert stage.look() == []
    assert not stage.at()[0]
    stage.handle(TokenCame(1, "a"))
    assert kinds(stage.look()) == ["PoseSampled", "PoseSampled"]
    assert stage.at()[0]
    assert [(told.t_s, told.phase) for told in stage.odometry[1]] == [(0.0, Phase.RUNNING)]


def test_a_run_ends_and_names_robots_that_never_come() -> None:
    stage = Stage(scenario())
    stage.handle(TokenCame(2, "a"))
    assert stage.look(after_wall_s=start_wall_s(2)) == []
    assert stage.at()[2] is Ending.MISSING
    assert stage.odometry[2][-1].phase is Phase.OVER
    stage.look(after_wall_s=LAST_WORDS_WALL_S)
    assert stage.look(after_wall_s=LAST_WORDS_WALL_S) == [RunEnded(reason="not all robots came: r1")]


def test_beside_other_fleets_the_robots_of_a_small_one_may_take_as_long_to_come_as_all() -> None:
    stage = Stage(scenario(), in_all=1000)
    assert stage.look(after_wall_s=start_wall_s(1000) - 1.0) == []
    assert stage.at()[2] is None
    assert stage.look(after_wall_s=1.0) == []
    assert stage.at()[2] is Ending.MISSING


def test_an_order_is_accepted_driven_finished_and_reported_at_once() -> None:
    stage = running()
    accepted = stage.order(1, AHEAD, step=1)
    assert kinds(accepted) == ["OrderAccepted"]
    records = stage.tick(SECOND)
    finished = [record for record in records if isinstance(record, OrderFinished)]
    assert [(each.robot, each.number, each.step, each.x_m) for each in finished] == [(1, 1, 1, 0.5)]
    assert finished[0].clearance_m == pytest.approx(((1.5 - 0.5) ** 2 + 0.6**2) ** 0.5 - 0.3 - 0.1)
    at_s = next(told.t_s for told in stage.odometry[1] if told.finished == 1)
    assert at_s == pytest.approx(1.0)


def test_a_finished_step_has_the_least_clearance_of_the_whole_step_despite_interruptions() -> None:
    stage = running()
    past_the_post = Point(x_m=2.5, y_m=0.0)
    stage.order(1, past_the_post, step=1)
    stage.tick(4 * SECOND)  # it has passed the nearest place
    stage.order(1, None, number=2)
    stage.tick(SECOND)
    stage.order(1, past_the_post, number=3, step=1)
    finished = [record for record in stage.tick(SECOND) if isinstance(record, StepFinished)]
    assert [(each.robot, each.step, each.x_m) for each in finished] == [(1, 1, 2.5)]
    assert finished[0].clearance_m == pytest.approx(0.6 - 0.3 - 0.1)
    assert stage.world.tally.switching_steps == 1


def test_a_step_that_is_ordered_again_at_its_end_is_finished_once() -> None:
    stage = running()
    stage.order(1, AHEAD, step=1)
    records = stage.tick(SECOND)
    for number, target, step in ((2, None, 0), (3, AHEAD, 1), (4, Point(x_m=0.6, y_m=0.0), 2)):
        records += stage.order(1, target, number=number, step=step) + stage.tick(SECOND)
    assert [each.step for each in records if isinstance(each, StepFinished)] == [1, 2]
    assert [each.number for each in records if isinstance(each, OrderFinished)] == [1, 3, 4]


def test_a_following_robot_finishes_orders_but_no_steps() -> None:
    stage = running()
    stage.order(2, Point(x_m=-0.5, y_m=0.0))
    records = stage.tick(SECOND)
    assert "OrderFinished" in kinds(records)
    assert "StepFinished" not in kinds(records)


def test_odometry_is_sent_every_tenth_of_a_second_and_when_an_order_is_finished() -> None:
    stage = running()
    stage.order(1, Point(x_m=0.12, y_m=0.0))
    stage.tick(4 * ODOMETRY_TICKS)
    assert [told.t_s for told in stage.odometry[1]] == pytest.approx([0.0, 0.1, 0.2, 0.24, 0.3, 0.4])
    assert [told.t_s for told in stage.odometry[2]] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert [told.moving for told in stage.odometry[1]] == [False, True, True, False, False, False]


def test_a_repeated_order_changes_nothing() -> None:
    stage = running()
    assert kinds(stage.order(1, AHEAD)) == ["OrderAccepted"]
    assert stage.order(1, AHEAD) == []
    assert stage.order(1, FAR) == []  # the same number, with another content


def test_a_refused_void_order_is_recorded() -> None:
    stage = running()
    stage.tick(2 * SECOND)
    refused = stage.order(1, AHEAD, basis_s=0.5)
    assert kinds(refused) == ["OrderRefused"]
    assert not stage.world.bodies.moving.any()


def test_the_body_of_a_frozen_robot_stops_once_and_continues_after_the_thaw() -> None:
    stage = running()
    stage.order(1, Point(x_m=0.9, y_m=0.0))
    records = stage.tick(2 * SECOND, awake=False)
    assert [record for record in records if isinstance(record, BodyStopped)] == [BodyStopped(robot=1)]
    stood_m = stage.world.bodies.place_m[0, 0]
    assert stood_m == pytest.approx(0.5 + 0.5 * TICK_S)
    assert stage.order(1, Point(x_m=0.9, y_m=0.0)) == []
    stage.tick(SECOND)
    assert stage.world.bodies.place_m[0, 0] == 0.9


def test_a_scan_is_served_and_shows_the_hull_of_the_other_robot() -> None:
    stage = running()
    served = stage.handle(ScanAsked(1, 1))
    assert kinds(served) == ["ScanServed"]
    assert isinstance(served[0], ScanServed)
    assert served[0].hits > 0
    assert stage.scans[0].ranges_m[0] == pytest.approx(0.5)  # straight back: 0.6 m minus a hull radius


def test_the_timeline_records_evenly_spaced_rays_of_a_large_scan() -> None:
    stage = running()
    stage.handle(ScanAsked(1, 3))
    served = next(each for each in stage.records if isinstance(each, ScanServed))
    whole_m = stage.scans[0].ranges_m
    assert len(whole_m) > 360 >= len(served.ranges_m) > 180
    assert served.ranges_m == pytest.approx(whole_m[:: len(whole_m) // len(served.ranges_m)], abs=0.0005)


def test_a_scan_shows_a_moving_obstacle_where_it_is_when_it_is_taken() -> None:
    track = [[0.0, 1.0, 0.0], [2.0, 2.0, 0.0]]
    stage = Stage(scenario({"id": "a", "shape": "circle", "radius_m": 0.1, "track": track}))
    stage.begin()
    for _ in range(2):
        stage.handle(ScanAsked(1, 1))
        stage.tick(SECOND)
    assert [scan.ranges_m[len(scan.ranges_m) // 2] for scan in stage.scans] == pytest.approx([0.9, 1.4])


def test_the_noise_of_scans_depends_only_on_seed_and_robot() -> None:
    def ranges_m(seed: int, *asked: int) -> list[tuple[float, ...]]:
        stage = Stage(scenario(sensor={"range_sigma_m": 0.002}), seed=seed)
        stage.begin()
        for robot in asked:
            stage.handle(ScanAsked(robot, 1))
        return [scan.ranges_m for scan in stage.scans]

    assert ranges_m(1, 1) == ranges_m(1, 1)
    assert ranges_m(1, 1) != ranges_m(2, 1)
    assert ranges_m(1, 2, 1)[1] == ranges_m(1, 1)[0]


def test_the_run_is_over_when_every_robot_has_arrived_and_closes_in_two_phases() -> None:
    stage = running()
    stage.order(1, AHEAD)
    stage.tick(3)
    stage.write(1, RobotArrived(progress_m=1.0))
    stage.look()
    assert stage.at()[2] is None
    stage.write(2, RobotArrived(progress_m=1.0))
    stage.look()
    assert stage.at()[1:] == (Phase.OVER, Ending.ARRIVED)
    assert not stage.world.bodies.moving.any()
    assert stage.order(2, AHEAD, number=7) == []  # it was on its way at the end of the run
    settle(stage, 1)
    stage.look()
    assert stage.at()[1] is Phase.OVER
    settle(stage, 2)
    stage.look()
    assert stage.at()[1] is Phase.CLOSING
    assert {told[-1].phase for told in stage.odometry.values()} == {Phase.CLOSING}
    leave(stage, 1)
    stage.look()
    assert stage.world.judgement is None
    leave(stage, 2)
    assert stage.look()[-1] == RunEnded(reason="every living robot has arrived")
    assert stage.world.judgement is not None


def settle(stage: Stage, robot: int) -> None:
    stage.write(robot, RobotSettled(sent={}))


def leave(stage: Stage, robot: int) -> None:
    stage.write(
        robot, TrafficCounted(sent={}, received={}, newest={}, refused={}, overflowed=0, unrecorded=0)
    )
    stage.handle(TokenWent(robot, "a"))


def test_the_last_phases_have_wall_clock_limits() -> None:
    stage = running()
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    stage.look(after_wall_s=LAST_WORDS_WALL_S - 0.01)
    assert stage.at()[1] is Phase.OVER
    stage.look(after_wall_s=0.01)
    assert stage.at()[1] is Phase.CLOSING
    assert stage.look(after_wall_s=LAST_WORDS_WALL_S) == [RunEnded(reason="interrupted")]


def test_a_lost_route_ends_the_run() -> None:
    stage = running()
    stage.write(1, RouteLost(reason="every gap is too narrow"))
    stage.look()
    assert stage.at()[2] is Ending.ROUTE_LOST


def test_the_run_ends_at_the_scenarios_time_limit() -> None:
    stage = running(time={"time_s_max": 1.0})
    stage.tick(SECOND - 1)
    stage.look()
    assert stage.at()[2] is None
    stage.tick()
    stage.look()
    assert stage.at()[2] is Ending.TIMED_OUT
    assert stage.world.over_s == pytest.approx(1.0)


def test_a_void_order_is_an_answer_in_lock_step_and_is_refused_once() -> None:
    stage = running()
    old = stage.bearing(1)
    stage.form(2)
    stage.order(1, AHEAD)
    stage.tick(ODOMETRY_TICKS, awake=False)
    assert kinds(stage.order(1, AHEAD, number=2, bearing=old)) == ["OrderRefused"]
    assert stage.order(1, AHEAD, number=2, bearing=old) == []
    assert kinds(stage.order(1, AHEAD, number=3, bearing=old)) == ["OrderRefused"]
    assert stage.world.awaited == {2}


def test_odometry_contains_the_number_of_the_newest_order() -> None:
    stage = running()
    stage.order(1, AHEAD, number=7)
    stage.tick(ODOMETRY_TICKS)
    assert (stage.odometry[1][-1].ordered, stage.odometry[1][-1].finished) == (7, 0)


def test_in_lock_step_every_living_robot_owes_an_answer_to_the_last_odometry() -> None:
    stage = running()
    assert stage.world.awaited == {1, 2}
    stage.order(1, None, number=0)
    assert stage.world.awaited == {2}
    stage.handle(TokenWent(2, "a"))
    assert stage.world.awaited == {2}  # it may return
    stage.look(after_wall_s=1.0)
    assert stage.world.awaited == set()


def test_an_answer_to_older_odometry_does_not_count_in_lock_step() -> None:
    stage = running()
    stage.tick(ODOMETRY_TICKS)
    stage.order(1, None, number=0, basis_s=0.0)
    assert stage.world.awaited == {1, 2}
    stage.order(1, None, number=0, basis_s=0.1)
    assert stage.world.awaited == {2}


@pytest.mark.parametrize("follows", [True, False])
def test_where_scans_are_followed_a_robot_owes_an_answer_a_tick_after_its_scan(follows: bool) -> None:
    """Lock-step makes the next ticks at once; a scan may permit a motion for two of them only."""
    stage = running()
    stage.world.arena.follow_scans(follows)
    for robot in (1, 2):
        stage.order(robot, None, number=0)
    stage.handle(ScanAsked(2, 1))
    stage.tick(awake=False)
    assert stage.world.awaited == ({2} if follows else set())
    stage.order(2, None, number=0, basis_s=0.02)
    stage.handle(ScanAsked(2, 1))
    stage.tick(awake=False)
    assert stage.world.awaited == set(), "the second scan is of no odometry instant"


def test_broken_promises_are_recorded_as_they_happen() -> None:
    stage = running()
    stage.lead(1, Point(x_m=1.5, y_m=0.0))
    broken = [record for record in stage.tick(4 * SECOND) if isinstance(record, PromiseBroken)]
    assert broken == []
    stage.lead(1, Point(x_m=1.5, y_m=0.2), number=2, step=2)
    broken = [record for record in stage.tick(SECOND) if isinstance(record, PromiseBroken)]
    assert [(each.invariant, each.robot) for each in broken] == [("S1", 1)]


def test_unlawful_motion_is_recorded_as_soon_as_it_is_certain() -> None:
    """A body that was never scanned is seen at once; the grant that it lacks may still be on its way."""
    stage = running()
    stage.order(2, Point(x_m=-1.0, y_m=0.0))
    at_once = [each for each in stage.look() if isinstance(each, PromiseBroken)]
    assert [(each.invariant, each.robot) for each in at_once] == [("F6", 2)]
    stage.tick(SECOND)
    stage.handle(StopAsked(ExitCode.INTERRUPTED))
    stage.look(after_wall_s=LAST_WORDS_WALL_S)
    *broken, ended = stage.look(after_wall_s=LAST_WORDS_WALL_S)
    assert ended == RunEnded(reason="interrupted")
    assert [(each.invariant, each.robot) for each in broken if isinstance(each, PromiseBroken)] == [
        ("F5", 2),
    ]


@pytest.mark.parametrize(("speed_mps", "refusals"), [(0.5, 0), (0.51, 1)])
def test_an_order_to_drive_faster_than_robots_drive_is_refused_and_breaks_nothing(
    speed_mps: float, refusals: int
) -> None:
    stage = running()
    stage.handle(ScanAsked(1, 1))
    stage.write(1, planned(AHEAD))
    drive = Drive(
        number=1,
        basis_s=stage.world.now_s,
        target=AHEAD,
        speed_mps=speed_mps,
        bearing=stage.bearing(1),
        step=1,
        reach_m=0.0,
    )
    answered = stage.handle(OrderHeard(1, drive))
    stage.tick(SECOND, awake=False)
    assert kinds(answered).count("OrderRefused") == refusals
    assert [each for each in stage.look() if isinstance(each, PromiseBroken)] == []


def test_refused_messages_are_recorded() -> None:
    stage = running()
    refused = MessageRefused(key="k", reason="why")
    assert stage.handle(MessageDropped("k", "why")) == [refused]


def test_a_body_is_sampled_where_its_motion_changes_and_with_each_odometry() -> None:
    stage = running()
    stage.order(1, Point(x_m=0.12, y_m=0.0))
    stage.tick(4 * ODOMETRY_TICKS)
    sampled = [entry.t_s for _, entry in stage.lines if isinstance(entry.record, PoseSampled)]
    # Placed (2 bodies); begins; 0.1 s and 0.2 s; the last two ticks are full; stands.
    assert sampled == pytest.approx([0.0, 0.0, 0.0, 0.1, 0.2, 0.24])
    accepted = [entry for _, entry in stage.lines if isinstance(entry.record, OrderAccepted)]
    assert len(accepted) == 1
