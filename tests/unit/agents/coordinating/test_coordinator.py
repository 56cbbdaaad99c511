"""When a coordinator goes on with its view."""

from agents.coordinating.agreeing import Intent
from agents.coordinating.coordinator import Coordinator
from agents.coordinating.phases import Phase
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from protocol.fence import Cause, Epoch, Fence
from protocol.frames import Point, Pose
from protocol.wire.messages import Odometry
from protocol.wire.messages import Phase as RunPhase
from protocol.wire.view import Report
from tests.support.stages.one_step import under

OWN, EPOCH = 1, Epoch(generation=2, robot=1, life=1)
MISSION = under("certified", robots=3, goal=Point(x_m=9.0, y_m=0.0))
TIMING = Timing.of(MISSION)
LATE_S = TIMING.reports_s + TIMING.listens_s + 1.0


def place(robot: int) -> Pose:
    return Pose(x_m=float(-robot), y_m=0.0, heading_rad=0.0)


def test_nothing_goes_on_before_the_coordinator_has_reported_to_itself_however_late_it_is() -> None:
    """It counts for the next formation what its own report says."""
    suspicion = Suspicion(TIMING)
    for robot in (0, 1, 2, 3):
        suspicion.presence.come(robot, "a", 0.0)
    coordinator = Coordinator(
        OWN, EPOCH, mission=MISSION, timing=TIMING, suspicion=suspicion, intent=Intent(Cause.START), now_s=0.0
    )

    def phase_after_reports_of(*robots: int) -> Phase:
        for robot in robots:
            report = Report(epoch=EPOCH, life=robot, number=1, turn=0, place=place(robot))
            coordinator.hear(robot, report, LATE_S)
        odometry = Odometry(
            n=1,
            t_s=LATE_S,
            pose=place(OWN),
            moving=False,
            finished=0,
            fence=Fence(epoch=EPOCH),
            phase=RunPhase.RUNNING,
        )
        coordinator.act(odometry, LATE_S)
        return coordinator.phase

    assert phase_after_reports_of(2, 3) is Phase.GATHERING
    assert phase_after_reports_of(OWN) is not Phase.GATHERING
