"""What a robot does at its first odometry: it may replace a process that has died."""

import pytest

from agents.body.driver import LATE_ORDERS
from agents.events import OdometryHeard
from agents.robot import LATE_S, Robot
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.wire.messages import Odometry, Phase
from tests.support.stages.one_step import under


@pytest.mark.parametrize(
    ("again", "ordered", "t_s", "replaces"),
    [(False, 0, 0.1, False), (True, 0, 0.1, True), (False, 7, 0.1, True), (False, 0, LATE_S + 0.1, True)],
    ids=["at the start", "started again", "its body has had orders", "it is late"],
)
def test_a_process_that_may_replace_another_first_orders_its_body_to_stand_by_a_higher_number(
    *, again: bool, ordered: int, t_s: float, replaces: bool
) -> None:
    robot = Robot(1, under("certified", robots=2), life=5, again=again)
    place = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
    odometry = Odometry(
        n=1,
        t_s=t_s,
        pose=place,
        moving=False,
        finished=0,
        ordered=ordered,
        fence=Fence(),
        phase=Phase.RUNNING,
    )
    robot.handle(OdometryHeard(odometry), t_s)
    assert robot.order.target is None
    assert (robot.order.number > ordered + LATE_ORDERS) is replaces
