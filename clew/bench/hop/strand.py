"""The cores of a strand that has formed, for the processes that are measured, and the leader's news. Pure.

Rule 1: the cores are those of a rehearsal in the tick in which the last robot has joined. Nobody has odometry
        after that, so no heartbeat is due, and all that is sent is the news.
Rule 2: the news is one more vertex of the path. Each robot takes it in and tells both its neighbours at once.
"""

from collections.abc import Mapping

from agents.robot import Robot
from agents.strand.member import Member
from agents.strand.news import TOLD_VERTICES_MAX
from clew.bench.forming import SEED, queue
from clew.rehearsal.rehearsal import Rehearsal
from protocol.exit_codes import ExitCode
from protocol.frames import Point
from protocol.mission import Mission
from protocol.timeline import StrandJoined
from protocol.wire.messages import AheadState

STEP_M = 0.01  # between two vertices: hundreds of them lie on the open ground before the queue


class Strand:
    """A queue of robots, formed, whose leader is robot 1."""

    def __init__(self, robots: int) -> None:
        scenario = queue(robots)
        self.mission: Mission = scenario.mission()
        rehearsal, joined = Rehearsal(scenario, SEED), 0
        for _ in rehearsal.ticks():
            joined = sum(isinstance(entry.record, StrandJoined) for _, entry in rehearsal.entries)
            if joined == robots and rehearsal.world.judgement is None:
                rehearsal.stop(ExitCode.INTERRUPTED)
                break
        assert joined == robots, f"{joined} of {robots} robots have joined"
        self.now_s = rehearsal.world.now_s
        self.cores: Mapping[int, Robot] = {
            number: actor.core for number, actor in rehearsal.processes.actors.items()
        }
        """By the number of the robot."""
        self._leader = self._member(1)
        assert [self._member(robot).formation.rank for robot in sorted(self.cores)] == [*range(robots)]
        self._path = self._leader.path.copy()
        self._known = len(self._path)

    def _member(self, robot: int) -> Member:
        member = self.cores[robot].member
        assert member is not None, "it has joined"
        return member

    @property
    def vertices(self) -> int:
        """How many vertices the path has."""
        return len(self._path)

    def confirm(self, vertices: int) -> None:
        """All robots know so many vertices."""
        self._known = vertices

    def news(self) -> AheadState:
        """The leader's next state: the path has one more vertex (rule 2)."""
        last = self._path[-1]
        self._path.extend(Point(x_m=last.x_m + STEP_M, y_m=last.y_m))
        path_from = self._known - 1  # what was lost is told again
        return AheadState(
            epoch=self._leader.formation.epoch,
            life=self._leader.formation.life,
            t_s=self.now_s,
            path_from=path_from,
            path=self._path.told_from(path_from, TOLD_VERTICES_MAX),
            progress_m=self._leader.progress_m,
            authority_m=0.0,
            arrived=False,
            vertices=len(self._path),
            backs_up=False,
        )
