"""How long a body that may not move is taken to be only waiting, where obstacles move."""

from msgspec.structs import replace

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.body.watch import STILL_S_MAX, Watch
from protocol.frames import Point, Pose
from protocol.mission import Law
from protocol.wire.messages import Odometry, Phase
from tests.support.stages.one_step import under

MISSION = replace(under(Law.CERTIFIED, robots=2, robot_radius_m=0.1), obstacle_speed_mps_max=0.5)
AHEAD = Point(x_m=2.0, y_m=0.0)
TICK_S = 0.1


class Body:
    """One robot's, whose order or place changes as told; time passes in tenths of a second."""

    def __init__(self) -> None:
        self.driver = Driver(speed_mps=MISSION.speed_mps, watched=True)
        self.watch = Watch(MISSION, self.driver, Senses(MISSION, self.driver))
        self.now_s, self.x_m = 0.0, 0.0
        self.wait(TICK_S)

    def wait(self, for_s: float, *, speed_mps: float = 0.0) -> bool:
        """So much time passes; whether the step in hand then had better be given up."""
        for _ in range(round(for_s / TICK_S)):
            self.now_s += TICK_S
            self.x_m += speed_mps * TICK_S
            drive = self.driver.drive
            finished = drive.number if drive.target is None else drive.number - 1
            pose = Pose(x_m=self.x_m, y_m=0.0, heading_rad=0.0)
            told = Odometry(t_s=self.now_s, pose=pose, moving=False, finished=finished, phase=Phase.RUNNING)
            self.driver.hear(told)
            self.watch.look(list, self.now_s)
        return self.watch.gives_up(self.now_s)

    def go(self) -> None:
        self.driver.to(AHEAD, reach_m=2.0, epoch=1)


def test_a_body_under_way_that_does_not_move_is_waited_for_so_long() -> None:
    body = Body()
    body.go()
    assert [body.wait(STILL_S_MAX), body.wait(0.3)] == [False, True]


def test_a_body_that_moves_again_is_waited_for_anew() -> None:
    body = Body()
    body.go()
    assert not body.wait(STILL_S_MAX - 1.0)
    assert not body.wait(1.0, speed_mps=0.1)
    assert not body.wait(STILL_S_MAX - 1.0)


def test_to_stand_for_a_silent_link_in_between_counts_for_nothing_and_makes_nothing_undone() -> None:
    body = Body()
    body.go()
    assert not body.wait(STILL_S_MAX - 2.0)
    body.driver.stand()
    assert not body.wait(5.0)
    body.go()
    assert [body.wait(1.5), body.wait(1.0)] == [False, True]
