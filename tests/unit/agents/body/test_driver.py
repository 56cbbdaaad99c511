"""The driver in conversation with a body that drives straight and reports its odometry."""

import math
from dataclasses import dataclass, field
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from agents.body.driver import LATE_ORDERS, Driver
from protocol.fence import Bearing, Epoch, Fence, May
from protocol.frames import Point, Pose
from protocol.wire.messages import Drive, Odometry, Phase

SPEED_MPS = 0.5
PERIOD_S = 0.1
STRIDE_M = SPEED_MPS * PERIOD_S
ROUNDING_M = 1e-9
FENCE = Fence(epoch=Epoch(generation=3, robot=1, life=7), turn=2, may=May.ALL)
BEARING = Bearing(epoch=FENCE.epoch, turn=2, life=7)
ODOMETRY_AT_START = Odometry(
    n=1,
    t_s=0.0,
    pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
    moving=False,
    finished=0,
    fence=FENCE,
    phase=Phase.RUNNING,
)


@dataclass
class Body:
    """Drives along the x axis towards the newest order's target, period by period."""

    x_m: float = 0.0
    t_s: float = 0.0
    finished: int = 0
    order: Drive | None = None
    fence: Fence = FENCE
    told: list[Odometry] = field(default_factory=list)

    def live(self) -> Odometry:
        """The odometry after one period."""
        self.t_s += PERIOD_S
        if self.order is not None:
            target_m = self.x_m if self.order.target is None else self.order.target.x_m
            self.x_m += max(-STRIDE_M, min(STRIDE_M, target_m - self.x_m))
            if self.x_m == target_m:
                self.finished = self.order.number
        self.told.append(self.tell())
        return self.told[-1]

    def tell(self) -> Odometry:
        pose = Pose(x_m=self.x_m, y_m=0.0, heading_rad=0.0)
        return replace(
            ODOMETRY_AT_START,
            n=1 + round(self.t_s / PERIOD_S),
            t_s=self.t_s,
            pose=pose,
            moving=True,
            finished=self.finished,
            fence=self.fence,
        )


def awake() -> tuple[Driver, Body]:
    driver, body = Driver(speed_mps=SPEED_MPS), Body()
    driver.hear(body.live())
    driver.begin(0.0, BEARING)
    return driver, body


def to(driver: Driver, x_m: float) -> None:
    """The path is the x axis, so that arc length and x are the same number."""
    driver.to(Point(x_m=x_m, y_m=0.0), reach_m=x_m)


def test_before_the_first_odometry_the_driver_is_neither_awake_nor_standing() -> None:
    driver = Driver(speed_mps=SPEED_MPS)
    assert (driver.awake, driver.standing) == (False, False)
    driver.hear(Body().tell())
    assert (driver.awake, driver.standing) == (True, True)


def test_an_order_is_driven_to_its_end_and_then_the_driver_stands() -> None:
    driver, body = awake()
    to(driver, 3.0 * STRIDE_M)
    body.order = driver.drive
    heard = []
    for _ in range(4):
        driver.hear(body.live())
        heard.append((driver.standing, driver.progress_m))
    assert [standing for standing, _ in heard] == [False, False, True, True]
    assert [progress_m for _, progress_m in heard] == pytest.approx([0.05, 0.10, 0.15, 0.15])


def test_an_order_that_the_stop_of_another_life_has_ended_is_not_finished() -> None:
    """A second process of the same robot stops the body: the first one must not grant ground beyond it."""
    driver, body = awake()
    to(driver, 3.0 * STRIDE_M)
    body.order = driver.drive
    driver.hear(body.live())
    body.order = replace(driver.drive, number=driver.drive.number + LATE_ORDERS, target=None)
    for _ in range(4):
        driver.hear(body.live())
        assert not driver.standing
        assert driver.progress_m == pytest.approx(STRIDE_M)


def test_the_current_order_is_confirmed_at_the_newest_odometry_and_keeps_its_number() -> None:
    driver, body = awake()
    to(driver, 1.0)
    first = driver.drive
    driver.hear(body.live())
    assert (driver.drive.number, driver.drive.target) == (first.number, first.target)
    assert (first.basis_s, driver.drive.basis_s) == pytest.approx((PERIOD_S, 2.0 * PERIOD_S))


def test_each_order_has_a_new_number_with_its_bearing_and_step() -> None:
    driver, _ = awake()
    driver.to(Point(x_m=1.0, y_m=2.0), reach_m=7.0, step=4)
    first = driver.drive
    driver.to(Point(x_m=2.0, y_m=2.0), reach_m=8.0)
    assert (first.number, first.bearing, first.step, first.reach_m) == (1, BEARING, 4, 7.0)
    assert (driver.drive.number, driver.drive.step, driver.drive.reach_m) == (2, 0, 8.0)
    assert driver.drive.speed_mps == SPEED_MPS


def test_the_order_to_stand_has_its_own_number_and_is_given_once() -> None:
    driver, body = awake()
    to(driver, 1.0)
    body.order = driver.drive
    driver.hear(body.live())
    for _ in range(3):
        driver.stand()
    assert (driver.drive.number, driver.drive.target) == (2, None)
    stood = [driver.standing]
    body.order = driver.drive
    driver.hear(body.live())
    assert [*stood, driver.standing] == [False, True]
    assert driver.progress_m == pytest.approx(body.x_m)


def test_a_standing_body_is_not_ordered_to_stand() -> None:
    driver, body = awake()
    driver.stand()
    assert driver.drive.number == 0
    to(driver, STRIDE_M)
    body.order = driver.drive
    driver.hear(body.live())
    driver.stand()
    assert driver.drive.number == 1


def test_after_a_stop_progress_counts_from_where_the_body_stopped() -> None:
    driver, body = awake()
    to(driver, 1.0)
    body.order = driver.drive
    driver.hear(body.live())
    driver.stand()
    driver.hear(body.live())  # the order to stand is still in transit
    body.order = driver.drive
    driver.hear(body.live())
    # Too low a progress would be safe now, but too high once the strand has turned round.
    assert driver.progress_m == pytest.approx(body.x_m) == pytest.approx(2.0 * STRIDE_M)
    to(driver, 1.0)
    driver.hear(body.tell())
    assert driver.progress_m == pytest.approx(2.0 * STRIDE_M)


def test_a_robot_knows_that_its_body_was_sent_before_odometry_shows_it_and_after_a_stop() -> None:
    driver, body = awake()
    sent = [driver.was_sent]
    to(driver, 0.5)
    sent.append(driver.was_sent)
    driver.stand()
    driver.hear(body.live())
    sent.append(driver.was_sent)
    driver.begin(0.0, BEARING)
    assert [*sent, driver.was_sent] == [False, True, True, False]


def test_the_same_odometry_again_changes_nothing() -> None:
    driver, body = awake()
    to(driver, 1.0)
    body.order = driver.drive
    driver.hear(body.live())
    before = (driver.drive, driver.progress_m, driver.standing)
    driver.hear(body.tell())
    assert (driver.drive, driver.progress_m, driver.standing) == before


actions = st.lists(
    st.one_of(st.floats(0.0, 0.7), st.sampled_from(["stand", "lost", "repeated"])), min_size=1, max_size=30
)


@given(actions)
def test_progress_is_the_driven_length_when_the_body_stands_and_never_more(
    actions: list[float | str],
) -> None:
    driver, body = awake()
    reach_m = 0.0
    for action in actions:
        before_m = driver.progress_m
        match action:
            case "stand":
                driver.stand()
            case "repeated":
                driver.hear(body.told[-1])
            case float() as further_m if driver.standing:
                reach_m = max(reach_m, driver.progress_m) + further_m
                to(driver, reach_m)
        if action != "lost":
            body.order = driver.drive
        driver.hear(body.live())
        assert before_m <= driver.progress_m <= body.x_m + ROUNDING_M
        if driver.standing:
            assert driver.progress_m == pytest.approx(body.x_m, abs=ROUNDING_M)


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.0, 5.0))
def test_the_progress_of_a_body_off_its_way_follows_from_the_distance_to_the_target(
    x_m: float, y_m: float, reach_m: float
) -> None:
    driver = Driver(speed_mps=SPEED_MPS)
    odometry = replace(ODOMETRY_AT_START, pose=Pose(x_m=x_m, y_m=y_m, heading_rad=0.0))
    driver.hear(odometry)
    driver.begin(0.0, BEARING)
    driver.to(Point(x_m=0.0, y_m=0.0), reach_m=reach_m)
    driver.hear(replace(odometry, n=2))
    assert driver.progress_m == max(0.0, reach_m - math.hypot(x_m, y_m))


def test_a_driver_that_begins_in_the_middle_of_the_path_has_that_progress() -> None:
    driver, body = awake()
    driver.begin(2.0, BEARING)
    driver.hear(body.live())
    assert driver.progress_m == 2.0


def test_a_restarted_robot_first_stops_its_body_with_a_number_above_all_late_orders() -> None:
    driver = Driver(speed_mps=0.5)
    driver.hear(replace(ODOMETRY_AT_START, ordered=57, finished=56, moving=True))
    driver.start_again()
    stands = 57 + LATE_ORDERS + 1
    assert (driver.drive.number, driver.drive.target) == (stands, None)
    standing = [driver.standing]
    driver.hear(replace(ODOMETRY_AT_START, n=2, t_s=0.1, ordered=stands, finished=stands))
    standing.append(driver.standing)
    assert standing == [False, True]
    driver.begin(0.0, BEARING)
    driver.to(Point(x_m=1.0, y_m=0.0), reach_m=1.0)
    assert driver.drive.number == stands + 1


def test_the_orders_of_each_life_have_higher_numbers_even_if_the_body_accepted_none_before() -> None:
    numbers = []
    for t_s in (0.4, 0.7, 9.0):
        driver = Driver(speed_mps=0.5)
        driver.hear(replace(ODOMETRY_AT_START, t_s=t_s))
        driver.start_again()
        numbers.append(driver.drive.number)
        assert not driver.standing, "the body must accept that order first"
    assert min(b - a for a, b in pairwise(numbers)) > LATE_ORDERS


def test_an_order_that_the_body_has_not_accepted_yet_is_not_counted_again() -> None:
    driver = Driver(speed_mps=0.5)
    driver.hear(ODOMETRY_AT_START)
    driver.begin(0.0, BEARING)
    driver.to(Point(x_m=1.0, y_m=0.0), reach_m=1.0)
    driver.hear(replace(ODOMETRY_AT_START, n=2, t_s=0.1, ordered=0))
    assert driver.drive.number == 1


# --- fences -----------------------------------------------------------------------------------------

NEXT = Fence(epoch=Epoch(generation=4, robot=2, life=8))


def under_way() -> tuple[Driver, Body]:
    """A body that has driven for one period of a long order."""
    driver, body = awake()
    to(driver, 1.0)
    body.order = driver.drive
    driver.hear(body.live())
    assert not driver.standing
    return driver, body


def test_an_order_has_ended_when_odometry_tells_another_fence_and_then_it_is_not_finished() -> None:
    driver, body = under_way()
    body.fence, body.order = NEXT, None
    driver.hear(body.live())
    assert driver.standing
    assert driver.progress_m == pytest.approx(body.x_m) == pytest.approx(STRIDE_M)


@pytest.mark.parametrize(
    "fence",
    [
        replace(FENCE, turn=3),
        replace(FENCE, epoch=replace(FENCE.epoch, generation=4)),
        replace(FENCE, epoch=replace(FENCE.epoch, generation=4, life=9)),
    ],
)
def test_a_change_of_the_turn_alone_ends_an_order_too(fence: Fence) -> None:
    driver, body = under_way()
    body.fence = fence
    driver.hear(body.tell())
    assert driver.standing


def test_a_dropped_order_is_not_repeated() -> None:
    driver, body = under_way()
    before = driver.drive.number
    body.fence, body.order = NEXT, None
    driver.hear(body.live())
    assert (driver.drive.target, driver.drive.number) == (None, before + 1)
    driver.begin(0.5, Bearing(epoch=NEXT.epoch, turn=0, life=7))
    assert driver.standing, "the body stands: it has dropped all orders of the old fence"


def test_an_order_that_was_finished_as_the_fence_changed_counts_as_finished() -> None:
    driver, body = awake()
    to(driver, STRIDE_M)
    body.order = driver.drive
    body.live()
    body.fence = NEXT
    driver.hear(body.tell())
    assert (driver.standing, driver.progress_m) == (True, STRIDE_M)


@pytest.mark.parametrize("fence", [NEXT, replace(FENCE, turn=1), replace(FENCE, turn=3)])
def test_no_motion_is_ordered_under_a_fence_that_odometry_does_not_tell(fence: Fence) -> None:
    driver = Driver(speed_mps=SPEED_MPS)
    driver.hear(replace(ODOMETRY_AT_START, fence=fence))
    driver.begin(0.0, BEARING)
    to(driver, 1.0)
    assert (driver.drive.target, driver.was_sent, driver.may_drive) == (None, False, False)


def test_no_motion_is_ordered_under_a_fence_that_is_not_in_force(monkeypatch: pytest.MonkeyPatch) -> None:
    driver, _ = awake()
    monkeypatch.setattr("agents.body.driver.in_force", lambda _: False)
    to(driver, 1.0)
    assert driver.drive.target is None


def test_the_newest_odometry_by_fence_and_number_is_valid_however_late_others_come() -> None:
    driver = Driver(speed_mps=SPEED_MPS)
    told = [
        replace(ODOMETRY_AT_START, n=5, fence=NEXT),
        replace(ODOMETRY_AT_START, n=9, fence=FENCE),
        replace(ODOMETRY_AT_START, n=5, fence=NEXT),
        replace(ODOMETRY_AT_START, n=4, fence=NEXT),
        replace(ODOMETRY_AT_START, n=6, fence=NEXT),
    ]
    assert [driver.hear(odometry) for odometry in told] == [True, False, False, False, True]
    assert driver.odometry == told[-1]


def test_a_change_of_the_fence_does_not_end_the_first_order_of_a_new_life() -> None:
    driver = Driver(speed_mps=SPEED_MPS)
    driver.hear(replace(ODOMETRY_AT_START, ordered=57, finished=56, moving=True))
    driver.start_again()
    driver.hear(replace(ODOMETRY_AT_START, n=2, fence=NEXT))
    assert not driver.standing, "an order of the former life may bear this fence, and be in transit"
    driver.begin(0.0, BEARING)
    assert not driver.standing
    driver.hear(replace(ODOMETRY_AT_START, n=3, fence=NEXT, finished=driver.drive.number))
    assert driver.standing


@pytest.mark.parametrize("permitted", [False, True])
def test_where_obstacles_move_the_body_is_told_to_drive_once_that_is_permitted(*, permitted: bool) -> None:
    driver, body = Driver(speed_mps=SPEED_MPS, watched=True), Body()
    driver.hear(body.live())
    driver.begin(0.0, BEARING)
    to(driver, 1.0)
    if permitted:
        driver.permit(1.0)
    assert driver.tells == permitted


def test_where_obstacles_move_the_body_is_told_to_stand_at_once() -> None:
    driver, body = Driver(speed_mps=SPEED_MPS, watched=True), Body()
    driver.hear(body.live())
    driver.begin(0.0, BEARING)
    to(driver, 1.0)
    driver.stand()
    assert driver.tells
