"""A coordinator without robots: a test says what they report, and odometry tells at once what it puts."""

from msgspec.structs import replace

from agents.commands import Put, Say
from agents.coordinating.agreeing import Intent, Turning
from agents.coordinating.coordinator import Coordinator
from agents.coordinating.draft import Drafted
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
BEGAN_S = 10.0
START = {1: (0.0, 0.0), 2: (-1.0, 3.0), 3: (-2.0, 3.0), 4: (-3.0, 3.0)}
BEHIND = {2: (-0.5, 0.0), 3: (-1.0, 0.0)}
"""Where robots 2 and 3 come to stand in their turns."""


def report(robot: int, at: tuple[float, float], *, look: Look | None = None, **said: int) -> Report:
    place = Pose(x_m=at[0], y_m=at[1], heading_rad=0.0)
    return replace(Report(epoch=EPOCH, life=robot, number=1, turn=0, place=place, look=look), **said)


class View:
    """A coordinator, and the fence that it puts."""

    def __init__(self, cause: Cause = Cause.START, *, turning: Turning | None = None) -> None:
        self.suspicion = Suspicion(TIMING)
        for robot in (0, *START):
            self.suspicion.presence.come(robot, "a", 0.0)
        self.suspicion.live(BEGAN_S)
        self.now_s, self.fence = BEGAN_S, Fence(epoch=EPOCH)
        self.answers: dict[int, Answer] = {}
        self._coordinator = Coordinator(
            EPOCH,
            mission=MISSION,
            timing=TIMING,
            suspicion=self.suspicion,
            intent=Intent(cause, turning=turning),
            now_s=self.now_s,
        )

    def hear(self, robot: int, said: Report) -> None:
        self._coordinator.hear(robot, said, self.now_s)

    def act(self, *, until_s: float = 0.0) -> None:
        """Let a tenth of a second pass; or as many as it takes until then."""
        self.now_s += 0.1
        self.suspicion.live(self.now_s)
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
        if self.now_s < until_s:
            self.act(until_s=until_s)

    def look(self, *clear: int) -> None:
        """All that are asked about their legs say what they see: these that theirs is clear."""
        for robot, at in START.items():
            question = self.answers[robot].question if robot in self.answers else None
            if question is not None:
                look = Look(number=question.number, clear=robot in clear)
                self.hear(robot, report(robot, at, number=2, look=look))

    @property
    def drafted(self) -> Drafted:
        return self._coordinator.drafted(self.now_s)

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
    view.look()
    view.act()
    assert (view.fence.may, view.fence.robot, view.fence.turn) == (May.ONE, 2, 1)
    view.act()
    view.hear(2, report(2, BEHIND[2], number=4, turn=1, ended=1, placed=True))
    view.act()
    assert (view.fence.may, view.fence.robot, view.fence.turn) == (May.ONE, 3, 2)
    view.act()
    return view
