import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from protocol.errors import MessageRefusedError
from protocol.fence import Bearing, Epoch, Fence, May
from protocol.frames import Point, Pose
from protocol.mission import DEADMAN_S
from protocol.wire.messages import Drive
from tests.support.strategies.examples import examples
from world.bodies.bodies import Bodies, Moves
from world.scenario.sections import DriveSection

TICK_S = 0.02
VIEW = Epoch(generation=3, robot=2, life=7)
STRAND = Fence(epoch=VIEW, turn=4, may=May.ALL, robot=1, members=3)
TURN = Fence(epoch=VIEW, turn=3, may=May.ONE, robot=1, life=11)
HOME = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)

places = st.builds(lambda x_m, y_m: Point(x_m=x_m, y_m=y_m), st.floats(-2, 2), st.floats(-2, 2))
headings = st.floats(-3.1, 3.1)
speeds = st.floats(0.2, 0.5)
quietly = settings(deadline=None, max_examples=examples(40))  # a case is 100s of ticks


def drive_section(heading_error_rad: float = 0.0) -> DriveSection:
    return DriveSection(
        speed_mps=0.5,
        speed_mps_min=0.05,
        speed_mps_max=1.0,
        turn_rate_radps=2.0,
        heading_error_rad=heading_error_rad,
    )


def bodies(*poses: Pose, heading_error_rad: float = 0.0) -> Bodies:
    return Bodies(
        poses, drive_section(heading_error_rad), [np.random.default_rng(n) for n in range(len(poses))]
    )


def bearing(fence: Fence, life: int = 11) -> Bearing:
    return Bearing(epoch=fence.epoch, turn=fence.turn, life=life)


def order(
    target: Point | None,
    *,
    number: int = 1,
    basis_s: float = 0.0,
    speed_mps: float = 0.5,
    bears: Bearing | None = None,
) -> Drive:
    return Drive(
        number=number,
        basis_s=basis_s,
        target=target,
        speed_mps=speed_mps,
        bearing=bearing(STRAND) if bears is None else bears,
        step=0,
        reach_m=0.0,
    )


def driven_m(fleet: Bodies, moves: Moves) -> float:
    """How far body 0 drove in a tick."""
    start = moves.starts.get(0)
    return 0.0 if start is None else math.dist(start[:2], fleet.place_m[0])


def drive_on(fleet: Bodies) -> list[float]:
    """Tick until body 0 stands, with regular messages of its robot; returns the distance of each tick."""
    drove_m: list[float] = []
    for tick in range(5000):
        last = fleet.orders[0]
        assert last is not None
        fleet.hear(
            0, order(last.target, number=last.number, basis_s=tick * TICK_S), STRAND, now_s=tick * TICK_S
        )
        if not fleet.moving[0]:
            return drove_m
        moves = fleet.tick(now_s=tick * TICK_S, tick_s=TICK_S)
        drove_m.append(driven_m(fleet, moves))
    raise AssertionError("the body never stood")


@quietly
@given(headings, places, speeds)
def test_without_drive_error_a_body_stands_exactly_at_its_target(
    heading_rad: float, target: Point, speed_mps: float
) -> None:
    fleet = bodies(Pose(x_m=0.3, y_m=-0.7, heading_rad=heading_rad))
    assert fleet.hear(0, order(target, speed_mps=speed_mps), STRAND, now_s=0.0)
    drive_on(fleet)
    assert fleet.place_m[0].tolist() == [target.x_m, target.y_m]
    assert fleet[0].finished_number == 1


@quietly
@given(headings, places, st.floats(0.001, 0.1))
def test_a_drive_with_error_ends_within_its_bound_and_is_finished(
    heading_rad: float, target: Point, error_rad: float
) -> None:
    fleet = bodies(Pose(x_m=0.0, y_m=0.0, heading_rad=heading_rad), heading_error_rad=error_rad)
    fleet.hear(0, order(target), STRAND, now_s=0.0)
    drive_on(fleet)
    miss_m = math.dist(fleet.place_m[0], (target.x_m, target.y_m))
    assert miss_m <= error_rad * math.hypot(target.x_m, target.y_m) + 1e-9
    assert fleet[0].finished_number == 1


@quietly
@given(headings, places, speeds)
def test_a_driving_body_keeps_the_ordered_speed_except_in_its_last_tick(
    heading_rad: float, target: Point, speed_mps: float
) -> None:
    fleet = bodies(Pose(x_m=0.0, y_m=0.0, heading_rad=heading_rad))
    fleet.hear(0, order(target, speed_mps=speed_mps), STRAND, now_s=0.0)
    drove_m = [way_m for way_m in drive_on(fleet) if way_m > 0.0]
    assert drove_m[:-1] == pytest.approx([speed_mps * TICK_S] * (len(drove_m) - 1))
    assert all(way_m <= speed_mps * TICK_S + 1e-12 for way_m in drove_m)


@quietly
@given(headings, places)
def test_a_tick_turns_or_drives_and_never_faster_than_the_turn_rate(
    heading_rad: float, target: Point
) -> None:
    fleet = bodies(Pose(x_m=0.0, y_m=0.0, heading_rad=heading_rad))
    fleet.hear(0, order(target), STRAND, now_s=0.0)
    for _ in range(40):
        before_rad = fleet[0].heading_rad
        moves = fleet.tick(now_s=0.0, tick_s=TICK_S)
        turned_rad = abs(math.remainder(fleet[0].heading_rad - before_rad, math.tau))
        drove_m = driven_m(fleet, moves)
        assert turned_rad == 0.0 or drove_m == 0.0
        assert turned_rad <= 2.0 * TICK_S + 1e-12
        assert -math.pi < fleet[0].heading_rad <= math.pi


@quietly
@given(st.lists(st.tuples(st.integers(1, 5), places), min_size=1, max_size=12))
def test_only_a_newer_number_changes_the_present_order(orders: list[tuple[int, Point]]) -> None:
    fleet = bodies(HOME)
    newest: tuple[int, Point | None] = (0, None)
    for number, target in orders:
        new = number > newest[0]
        newest = (number, target) if new else newest
        assert fleet.hear(0, order(target, number=number), STRAND, now_s=0.0) is new
        assert fleet.orders[0] is not None
        assert (fleet.orders[0].number, fleet.orders[0].target) == newest


@quietly
@given(headings)
def test_a_body_that_faces_the_next_target_continues_without_stopping(bearing_rad: float) -> None:
    def ahead(distance_m: float) -> Point:
        return Point(x_m=distance_m * math.cos(bearing_rad), y_m=distance_m * math.sin(bearing_rad))

    fleet = bodies(Pose(x_m=0.0, y_m=0.0, heading_rad=bearing_rad))
    fleet.hear(0, order(ahead(0.5)), STRAND, now_s=0.0)
    drove_m = []
    for tick in range(100):
        if tick == 40:
            fleet.hear(0, order(ahead(1.0), number=2), STRAND, now_s=0.0)
        moves = fleet.tick(now_s=0.0, tick_s=TICK_S)
        drove_m.append(driven_m(fleet, moves))
    assert drove_m == pytest.approx([0.01] * 100)
    assert fleet[0].finished_number == 2


def test_the_same_target_again_draws_no_new_drive_error() -> None:
    fleet = bodies(HOME, heading_error_rad=0.1)
    fleet.hear(0, order(Point(x_m=1.0, y_m=1.0)), STRAND, now_s=0.0)
    for tick in range(100):
        fleet.hear(0, order(Point(x_m=1.0, y_m=1.0), number=tick + 2), STRAND, now_s=0.0)
        fleet.tick(now_s=0.0, tick_s=TICK_S)
    alone = bodies(HOME, heading_error_rad=0.1)
    alone.hear(0, order(Point(x_m=1.0, y_m=1.0)), STRAND, now_s=0.0)
    for _ in range(100):
        alone.tick(now_s=0.0, tick_s=TICK_S)
    assert fleet.pose(0) == alone.pose(0)


def test_a_body_stops_once_when_its_robot_is_silent_and_continues_when_it_sends() -> None:
    fleet = bodies(HOME)
    far = Point(x_m=4.0, y_m=0.0)
    fleet.hear(0, order(far), STRAND, now_s=0.0)
    stopped_s = [
        tick * TICK_S for tick in range(100) if fleet.tick(now_s=tick * TICK_S, tick_s=TICK_S).stopped
    ]
    assert stopped_s == [pytest.approx(DEADMAN_S + TICK_S)]
    stood_m = fleet.place_m.copy()
    assert not fleet.moving[0]
    assert not fleet.hear(0, order(far, basis_s=2.0), STRAND, now_s=2.0)
    fleet.tick(now_s=2.0, tick_s=TICK_S)
    assert fleet.place_m[0, 0] == pytest.approx(stood_m[0, 0] + 0.01)


def test_an_order_without_a_target_stops_the_body_and_is_finished_at_once() -> None:
    fleet = bodies(HOME)
    fleet.hear(0, order(Point(x_m=4.0, y_m=0.0)), STRAND, now_s=0.0)
    fleet.hear(0, order(None, number=2, speed_mps=0.0), STRAND, now_s=0.0)
    fleet.tick(now_s=0.0, tick_s=TICK_S)
    assert fleet.place_m.tolist() == [[0.0, 0.0]]
    assert fleet[0].finished_number == 2


@pytest.mark.parametrize(
    ("drive", "why"),
    [
        (order(Point(x_m=1.0, y_m=0.0), number=9, basis_s=3.9), "void"),
        (order(Point(x_m=1.0, y_m=0.0), number=9, basis_s=5.1), "void"),
        (order(Point(x_m=1.0, y_m=0.0), number=9, basis_s=5.0, bears=bearing(TURN)), "bears .* turn 3"),
        (order(Point(x_m=1.0, y_m=0.0), number=9, basis_s=5.0, speed_mps=0.05), "speed"),
        (order(Point(x_m=1.0, y_m=0.0), number=9, basis_s=5.0, speed_mps=0.51), "speed must be in"),
    ],
)
def test_void_orders_change_nothing_and_do_not_keep_the_body_awake(drive: Drive, why: str) -> None:
    fleet = bodies(HOME)
    fleet.hear(0, order(None, basis_s=4.5), STRAND, now_s=4.5)
    with pytest.raises(MessageRefusedError, match=why):
        fleet.hear(0, drive, STRAND, now_s=5.0)
    assert fleet.orders[0] is not None
    assert fleet.orders[0].number == 1
    assert fleet.basis_s(0) == 4.5


def test_the_dead_man_time_counts_from_the_basis_and_not_from_the_arrival_of_an_order() -> None:
    fleet = bodies(HOME)
    fleet.hear(0, order(Point(x_m=4.0, y_m=0.0), basis_s=0.0), STRAND, now_s=0.9)
    stopped_s = [
        tick * TICK_S for tick in range(45, 100) if fleet.tick(now_s=tick * TICK_S, tick_s=TICK_S).stopped
    ]
    assert stopped_s == [pytest.approx(DEADMAN_S + TICK_S)]


def test_an_older_order_that_arrives_late_does_not_keep_the_body_moving() -> None:
    fleet = bodies(HOME)
    far = Point(x_m=4.0, y_m=0.0)
    fleet.hear(0, order(far, number=2, basis_s=0.0), STRAND, now_s=0.0)
    assert not fleet.hear(0, order(far, number=1, basis_s=0.8), STRAND, now_s=0.8)
    assert not fleet.hear(0, order(far, number=0, basis_s=1.0), STRAND, now_s=1.0)
    assert fleet.basis_s(0) == 0.0


# --- the fence (F1) -------------------------------------------------------------------------------

FAR = Point(x_m=4.0, y_m=0.0)


def test_an_order_to_stand_bears_no_fence_and_is_always_obeyed() -> None:
    fleet = bodies(HOME)
    fleet.hear(0, order(FAR), STRAND, now_s=0.0)
    assert fleet.hear(0, order(None, number=2, bears=Bearing()), STRAND, now_s=0.0)
    assert not fleet.moving[0]
    assert (fleet[0].ordered, fleet[0].finished_number) == (2, 2)
    stopped = Fence(epoch=VIEW.next(0, 0), may=May.STOPPED)
    assert fleet.hear(0, order(None, number=3, bears=Bearing()), stopped, now_s=0.0)


@pytest.mark.parametrize(
    ("bears", "fence"),
    [
        (bearing(replace(STRAND, turn=3)), STRAND),
        (bearing(replace(STRAND, turn=5)), STRAND),
        (bearing(replace(STRAND, epoch=replace(VIEW, generation=2))), STRAND),
        (bearing(replace(STRAND, epoch=replace(VIEW, robot=3))), STRAND),
        (bearing(replace(STRAND, epoch=replace(VIEW, life=8))), STRAND),
        (Bearing(), Fence()),
        (bearing(TURN, life=12), TURN),
        (bearing(TURN), replace(TURN, robot=2)),
        (bearing(TURN), replace(TURN, may=May.NOBODY, robot=0, life=0)),
        (bearing(TURN), replace(TURN, may=May.STOPPED)),
    ],
)
def test_a_body_drives_only_by_an_order_that_bears_exactly_its_fence_which_names_the_robot(
    bears: Bearing, fence: Fence
) -> None:
    fleet = bodies(HOME)
    with pytest.raises(MessageRefusedError, match="order 1 is void: it bears"):
        fleet.hear(0, order(FAR, bears=bears), fence, now_s=0.0)
    assert fleet[0].ordered == 0
    assert not fleet.moving[0]


def test_the_robot_that_a_turn_names_drives_and_no_other() -> None:
    fleet = bodies(HOME, HOME)
    assert fleet.hear(0, order(FAR, bears=bearing(TURN)), TURN, now_s=0.0)
    with pytest.raises(MessageRefusedError, match="robot 1 may move"):
        fleet.hear(1, order(FAR, bears=bearing(TURN)), TURN, now_s=0.0)
    assert fleet.moving.tolist() == [True, False]


def test_a_dropped_order_is_neither_finished_nor_confirmed_by_its_repetition() -> None:
    fleet = bodies(HOME)
    fleet.hear(0, order(FAR, number=7, bears=bearing(TURN)), TURN, now_s=0.0)
    fleet.tick(now_s=0.0, tick_s=TICK_S)
    stood_m = fleet.place_m.copy()
    fleet.stand()  # as the fence changes
    assert (fleet[0].ordered, fleet[0].finished_number) == (7, 0)
    with pytest.raises(MessageRefusedError, match="void"):
        fleet.hear(0, order(FAR, number=7, bears=bearing(TURN), basis_s=0.1), STRAND, now_s=0.1)
    assert not fleet.hear(0, order(FAR, number=7, basis_s=0.2), STRAND, now_s=0.2)
    moves = fleet.tick(now_s=0.2, tick_s=TICK_S)
    assert fleet.place_m.tolist() == stood_m.tolist()
    assert moves.finished == []
    assert fleet.hear(0, order(FAR, number=8, basis_s=0.2), STRAND, now_s=0.2)
    assert fleet.moving[0]


def test_an_order_of_another_fence_does_not_confirm_one_that_the_dead_man_stop_holds() -> None:
    fleet = bodies(HOME)
    fleet.hear(0, order(FAR), STRAND, now_s=0.0)
    for tick in range(100):
        fleet.tick(now_s=tick * TICK_S, tick_s=TICK_S)
    for target in (FAR, None):
        with pytest.raises(MessageRefusedError, match="void"):
            fleet.hear(0, order(target, bears=bearing(TURN), basis_s=2.0), STRAND, now_s=2.0)
        assert not fleet.moving[0]
    assert not fleet.hear(0, order(FAR, basis_s=2.0), STRAND, now_s=2.0)
    assert fleet.moving[0]


def test_each_body_obeys_only_its_own_robot() -> None:
    fleet = bodies(HOME, Pose(x_m=0.0, y_m=1.0, heading_rad=0.0), Pose(x_m=0.0, y_m=2.0, heading_rad=0.0))
    fleet.hear(1, order(Point(x_m=1.0, y_m=1.0)), STRAND, now_s=0.0)
    moves = fleet.tick(now_s=0.0, tick_s=TICK_S)
    assert fleet.place_m.tolist() == [[0.0, 0.0], [0.01, 1.0], [0.0, 2.0]]
    assert (moves.starts, moves.veered) == ({1: (0.0, 1.0, 0.0)}, [1])
    assert fleet.tick(now_s=0.0, tick_s=TICK_S).veered == []


def test_a_body_that_stops_veers_once_and_is_at_rest_then() -> None:
    fleet = bodies(HOME)
    fleet.hear(0, order(Point(x_m=0.015, y_m=0.0)), STRAND, now_s=0.0)
    veered = [(fleet.tick(now_s=0.0, tick_s=TICK_S)).veered for _ in range(5)]
    assert veered == [[0], [0], [0], [], []]  # it begins, its last step is shorter, it stands
    assert fleet.tick(now_s=0.0, tick_s=TICK_S).starts == {}


def test_the_places_are_those_of_now_and_nobody_can_change_them() -> None:
    fleet = bodies(HOME)
    fleet.place_m[0] = 5.0
    assert fleet.place_m.tolist() == [[0.0, 0.0]]
    fleet.resume(0, Pose(x_m=1.0, y_m=2.0, heading_rad=0.0), ordered=0, finished=0, now_s=0.0)
    assert fleet.place_m.tolist() == [[1.0, 2.0]]
