"""The points of a robot's step, as sequences of events and commands."""

from agents.commands import AskScan, Command, Note, Order, Tell
from agents.events import Event, OdometryHeard, ScanHeard
from agents.process.points import Points
from protocol.faults.rules import StepPoint
from protocol.fence import Bearing, Epoch, Fence
from protocol.frames import Point, Pose
from protocol.process.tokens import TokenCame
from protocol.timeline import RobotHeld
from protocol.wire.messages import BehindState, Drive, Odometry, Phase, Scan
from tests.support.planned import planned

AFTER_SCAN, AFTER_PLAN = StepPoint.AFTER_SCAN, StepPoint.AFTER_PLAN
MID_DRIVE, BEFORE_ACK = StepPoint.MID_DRIVE, StepPoint.BEFORE_ACK


def odometry(x_m: float, *, moving: bool = True) -> OdometryHeard:
    pose = Pose(x_m=x_m, y_m=0.0, heading_rad=0.0)
    return OdometryHeard(
        Odometry(n=1, t_s=0.0, pose=pose, moving=moving, finished=0, fence=Fence(), phase=Phase.RUNNING)
    )


def order(number: int, x_m: float | None) -> Order:
    target = None if x_m is None else Point(x_m=x_m, y_m=0.0)
    return Order(
        Drive(
            number=number, basis_s=0.0, target=target, speed_mps=0.5, bearing=Bearing(), step=1, reach_m=0.0
        )
    )


def knows(vertices: int, *, epoch: int = 1) -> Tell:
    return Tell(
        1,
        BehindState(
            epoch=Epoch(generation=epoch, robot=1, life=5),
            life=6,
            t_s=0.0,
            vertices=vertices,
            progress_m=0.0,
            tail_progress_m=0.0,
            stand=True,
        ),
    )


SCAN = ScanHeard(
    Scan(t_s=0.0, pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0), ranges_m=(1.0,) * 8, fence=Fence())
)
QUIET = TokenCame(2, "1")


def play(*steps: tuple[Event, list[Command], list[StepPoint]]) -> None:
    points = Points()
    for number, (event, commands, expected) in enumerate(steps):
        assert points.passed(event, commands) == expected, f"step {number}"


def test_each_scan_is_a_point_and_a_plan_is_another() -> None:
    play(
        (SCAN, [], [AFTER_SCAN]),
        (SCAN, [Note(planned(1)), order(1, 1.0)], [AFTER_SCAN, AFTER_PLAN]),
        (QUIET, [Note(RobotHeld(behind_m=1.0)), AskScan(1)], []),
    )


def test_the_middle_of_the_way_is_passed_once_per_order() -> None:
    play(
        (odometry(0.0, moving=False), [order(1, 2.0)], []),
        (odometry(0.9), [order(1, 2.0)], []),
        (odometry(1.0), [order(1, 2.0)], [MID_DRIVE]),
        (odometry(1.5), [order(1, 2.0)], []),
        (odometry(2.0, moving=False), [order(2, 4.0)], []),
        (odometry(2.9), [order(2, 4.0)], []),
        (odometry(3.3), [order(3, None)], [MID_DRIVE]),
        (odometry(3.4), [order(3, None)], []),
    )


def test_a_standing_body_passes_no_middle() -> None:
    play((odometry(0.0, moving=False), [order(1, 2.0)], []), (odometry(1.5, moving=False), [], []))


def test_only_new_vertices_are_an_acknowledgement_and_each_epoch_counts_again() -> None:
    play(
        (QUIET, [knows(2)], [BEFORE_ACK]),
        (QUIET, [knows(2)], []),
        (QUIET, [knows(3)], [BEFORE_ACK]),
        (QUIET, [knows(1, epoch=2)], [BEFORE_ACK]),
    )
