"""What a coordinator does with reports of two lives of one robot."""

from msgspec.structs import replace

from agents.commands import Put, Say
from agents.coordinating.agreeing import Intent
from agents.coordinating.coordinator import Coordinator
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from protocol.fence import Cause, Epoch, Fence, May, Turn
from protocol.frames import Point, Pose
from protocol.wire.messages import Odometry, Phase
from protocol.wire.view import Answer, Join, Look, Report
from tests.support.stages.one_step import under

OWN, EPOCH = 1, Epoch(generation=2, robot=1, life=1)
MISSION = under("certified", robots=4, goal=Point(x_m=9.0, y_m=0.0))
TIMING = Timing.of(MISSION)
START = {1: (0.0, 0.0), 2: (-1.0, 3.0), 3: (-2.0, 3.0), 4: (-3.0, 3.0)}
BEHIND = {2: (-0.5, 0.0), 3: (-1.0, 0.0)}
"""Where robots 2 and 3 come to stand in their turns."""


def report(robot: int, at: tuple[float, float], *, look: Look | None = None, **said: int) -> Report:
    place = Pose(x_m=at[0], y_m=at[1], heading_rad=0.0)
    return replace(Report(epoch=EPOCH, life=robot, number=1, turn=0, place=place, look=look), **said)


class View:
    """A coordinator, and the fence that it puts, which odometry tells at once."""

    def __init__(self) -> None:
        suspicion = Suspicion(TIMING)
        for robot in (0, *START):
            suspicion.presence.come(robot, "a", 0.0)
        suspicion.live(0.0)
        self.now_s, self.fence = 10.0, Fence(epoch=EPOCH)
        self.answers: dict[int, Answer] = {}
        self._coordinator = Coordinator(
            OWN,
            EPOCH,
            mission=MISSION,
            timing=TIMING,
            suspicion=suspicion,
            intent=Intent(Cause.START),
            now_s=self.now_s,
        )

    def hear(self, robot: int, said: Report) -> None:
        self._coordinator.hear(robot, said, self.now_s)

    def act(self) -> None:
        self.now_s += 0.1
        told = Odometry(
            n=1,
            t_s=self.now_s,
            pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
            moving=False,
            finished=0,
            fence=self.fence,
            phase=Phase.RUNNING,
        )
        for command in self._coordinator.act(told, self.now_s):
            match command:
                case Put(Turn(fence=fence)):
                    self.fence = fence
                case Say(robot, Answer() as answer):
                    self.answers[robot] = answer
                case _:
                    pass

    @property
    def join(self) -> Join:
        answer = self.answers[self.fence.robot].join
        assert answer is not None
        assert answer.turn == self.fence.turn
        return answer


def with_turns() -> View:
    """Nobody sees its leg, robot 2 has come to its place by turn 1, and robot 3 has turn 2."""
    view = View()
    for robot, at in START.items():
        view.hear(robot, report(robot, at))
    view.act()
    for robot, at in START.items():
        question = view.answers[robot].question
        if question is not None:
            view.hear(robot, report(robot, at, number=2, look=Look(number=question.number)))
    view.act()
    assert (view.fence.may, view.fence.robot, view.fence.turn) == (May.ONE, 2, 1)
    view.act()
    view.hear(2, report(2, BEHIND[2], number=4, turn=1, ended=1, placed=True))
    view.act()
    assert (view.fence.may, view.fence.robot, view.fence.turn) == (May.ONE, 3, 2)
    view.act()
    assert [(at.x_m, at.y_m) for at in view.join.strand] == [START[1], BEHIND[2]]
    return view


def test_v18_a_place_that_another_life_tells_late_is_told_to_nobody_that_joins() -> None:
    """A robot that waits for news of its turn says where it stands; its next life may be heard first."""
    view = with_turns()
    view.hear(2, report(2, BEHIND[2], life=22, turn=1))
    view.hear(2, report(2, START[2], number=3, turn=1))
    view.hear(3, report(3, BEHIND[3], number=3, turn=2, ended=2, placed=True))
    for _ in range(3):
        view.act()
    assert view.fence.may is May.NOBODY, "first robot 2 tells a place that is newer than its turn"
