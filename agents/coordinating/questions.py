"""What a coordinator asks robots to look at, and what they have seen. Pure.

Rule 1: a question about a leg names where both robots stand. An answer counts as long as they stand there,
        and no robot has had a turn since: it may stand on that leg now. What has been driven stays clear.
Rule 2 (safety): a driven way counts only if it leads from where the robot stands to where the robot ahead
        stands. The formation has the robot ahead at its end: a robot that lies could lead that one astray.
Rule 3: a robot that does not answer in time counts as one that does not see its way. Another question
        does not begin that time anew: two such times are longer than the others wait for a turn.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from agents.coordinating.order import Reports, places_of, positions
from agents.liveness.timing import Timing
from protocol.arrays import Floats, points_of
from protocol.frames import Point, Pose, apart_m
from protocol.legs import off_place_m_max
from protocol.mission import Mission
from protocol.wire.view import Look, Question, Report

OTHERS_MAX = 64  # robots that a scan may show beside a leg


@dataclass(frozen=True, slots=True)
class _Asked:
    question: Question
    at: Pose
    """Where the robot that is asked stands."""
    since_s: float
    """Since when its answer has been awaited."""
    turn: int
    """The newest turn that had been put."""
    look: Look | None = None


@dataclass(slots=True)
class Questions:
    """All questions of one view."""

    mission: Mission
    timing: Timing
    _asked: dict[int, _Asked] = field(default_factory=dict)
    _count: int = 0

    def ask(
        self, order: Sequence[int], reports: Reports, now_s: float, *, turn: int, keeps: bool
    ) -> list[int]:
        """Ask all robots but the leader to look at their legs; returns the robots that have a new question.

        Without an `order`, all are to look how far off the nearest obstacle is. `turn`: the newest that has
        been put; `keeps`: whether robots may tell legs of former strands.
        """
        ahead_of: dict[int, Report | None] = dict.fromkeys(reports)
        if order:
            ahead_of = {robot: reports[ahead] for ahead, robot in pairwise(order)}
        where, new = positions(places_of(reports), list(reports)), list[int]()
        for robot in self._asked.keys() - ahead_of.keys():
            del self._asked[robot]
        for robot, ahead in ahead_of.items():
            at, place = reports[robot].place, None if ahead is None else ahead.place
            asked = self._asked.get(robot)
            if (
                asked is not None
                and (asked.at, asked.question.place) == (at, place)
                and (asked.turn == turn or self.sees(robot).driven)
            ):
                continue  # rule 1
            self._count += 1
            question = Question(
                number=self._count,
                place=place,
                formers=ahead.formers if ahead is not None and keeps else (),
                others=self._beside(at, where),
            )
            since_s = now_s if asked is None or asked.look is not None else asked.since_s  # rule 3
            self._asked[robot] = _Asked(question, at, since_s, turn)
            new.append(robot)
        return new

    def hear(self, robot: int, look: Look | None) -> None:
        """Take in an answer."""
        asked = self._asked.get(robot)
        if look is not None and asked is not None and look.number == asked.question.number:
            look = look if self._may_be_driven(look.way, asked) else Look(number=look.number)
            self._asked[robot] = replace(asked, look=look)

    def pending(self, robot: int) -> Question | None:
        """What a robot has not answered yet."""
        asked = self._asked.get(robot)
        return None if asked is None or asked.look is not None else asked.question

    def awaited(self, now_s: float) -> set[int]:
        """The robots that have not answered, and have not been waited for long enough (rule 3)."""
        return {
            robot
            for robot, asked in self._asked.items()
            if asked.look is None and now_s - asked.since_s <= self.timing.looks_s
        }

    def sees(self, robot: int) -> Look:
        """What a robot sees; nothing, if it has not answered."""
        asked = self._asked.get(robot)
        return Look(number=0) if asked is None or asked.look is None else asked.look

    def obstacle_m(self, robots: Iterable[int]) -> dict[int, float]:
        """Each robot's distance from the nearest obstacle, as far as it is known."""
        told = {robot: self.sees(robot).obstacle_m for robot in robots}
        return {robot: self.mission.range_m_max if m is None else m for robot, m in told.items()}

    def _may_be_driven(self, way: Sequence[Point], asked: _Asked) -> bool:
        """Whether rule 2 admits this way; an empty one says that none was driven."""
        place, off_m_max = asked.question.place, off_place_m_max(self.mission)
        if not way or place is None:
            return not way
        return apart_m(asked.at, way[0]) <= off_m_max and apart_m(place, way[-1]) <= off_m_max

    def _beside(self, at: Pose, where: Floats) -> tuple[Point, ...]:
        """Where the nearest other robots stand that a scan from there may show."""
        off_m = np.hypot(where[:, 0] - at.x_m, where[:, 1] - at.y_m)
        near = np.flatnonzero((off_m > 0.0) & (off_m <= self.mission.leg_m_max + self.mission.robot_keep_m))
        nearest = near[np.argsort(off_m[near], kind="stable")[:OTHERS_MAX]]
        return points_of(where[nearest])
