"""What a coordinator tells the robots of its view: answers to reports, and news. Pure.

Rule 1: each report is answered; once the formation is made, a robot that is in it is sent its pieces instead.
Rule 2 (liveness): it does not wait for reports to answer, but repeats its news: a question until it is
        answered; the end of the strand until the robot that has the turn moves; that a turn was put until its
        robot tells a newer place; that a map is wanted until it comes; the formation for a short time.
"""

from collections.abc import Iterable, Set
from dataclasses import dataclass, field

from agents.commands import Command, Say
from agents.coordinating.draft import Draft
from agents.coordinating.formation import Plan
from agents.coordinating.questions import Questions
from agents.coordinating.reported import Reported
from agents.coordinating.turns import Turns
from agents.due import is_due
from agents.liveness.timing import Timing
from protocol.wire.messages import Odometry
from protocol.wire.view import Answer, Join, Report

NEWS_S = 1.0  # ten times: at 75 % loss a formation arrives in 94 % of cases; then it is asked for


@dataclass(slots=True)
class Telling:
    """The messages of one coordinator."""

    timing: Timing
    reported: Reported
    questions: Questions
    turns: Turns
    draft: Draft
    plan: Plan | None = None
    """The formation, once it is made."""
    _due: set[int] = field(default_factory=set)
    """Whom to answer."""
    _join: Join | None = None
    """For the robot that has the turn."""
    _made_s: float = -float("inf")
    _news_at_s: float = -float("inf")

    def tell(self, plan: Plan, now_s: float) -> list[Command]:
        """The formation is made: send it to its members."""
        self.plan = plan
        self._made_s = self._news_at_s = now_s
        self._due.difference_update(plan.order)
        return [Say(robot, piece) for robot in plan.order for piece in plan.pieces(robot)]

    def ask(self, robots: Iterable[int]) -> None:
        """There is something to tell these robots: they are answered at the next `act`."""
        self._due.update(robots)

    def give_turn(self, robot: int, join: Join) -> None:
        """A robot gets the turn: tell it where the strand ends that it joins."""
        self._join = join
        self.ask({robot})

    def act(self, odometry: Odometry, now_s: float, *, map_from: Set[int]) -> list[Command]:
        """Answer all reports, and repeat news if it is time; `map_from`: whose map is wanted."""
        if is_due(last_s=self._news_at_s, every_s=self.timing.report_s, now_s=now_s):
            self._news_at_s = now_s
            self._due |= self._hear_no_news(odometry, now_s, map_from)
        plan, commands = self.plan, list[Command]()
        for robot in sorted(self._due):
            report = self.reported.said[robot]
            if plan is not None and robot in plan.members and plan.members[robot].life == report.life:
                commands += [Say(robot, piece) for piece in plan.pieces(robot)]
            else:
                commands.append(Say(robot, self._answer(robot, report, wants_map=robot in map_from)))
        self._due.clear()
        return commands

    def _hear_no_news(self, odometry: Odometry, now_s: float, map_from: Set[int]) -> set[int]:
        """Rule 2: the robots that may not have heard their news."""
        counted = self.reported.counted
        if self.plan is not None:
            return set(self.plan.order) if now_s - self._made_s <= NEWS_S else set()
        news = {robot for robot in counted if self.questions.pending(robot) is not None}
        news |= self.reported.old(counted.keys(), self.turns) - {self.turns.holder}
        if odometry.stood_s >= self.timing.put_s:
            news |= {odometry.fence.robot} & counted.keys()
        return news | {robot for robot in map_from if counted[robot].seen is None}

    def _answer(self, robot: int, report: Report, *, wants_map: bool) -> Answer:
        has_turn, strand = self.turns.holder == robot, self.draft.strand
        return Answer(
            epoch=self.turns.newest.epoch,
            life=report.life,
            heard=report.number,
            after_turn=self.turns.put_for[robot],
            out=self.plan is not None,
            question=None if has_turn else self.questions.pending(robot),  # a message has room for one
            join=self._join if has_turn else None,
            rank=strand.index(robot) if robot in strand else None,
            wants_map=wants_map,
        )
