"""What a coordinator tells the robots of its view: answers to reports, and news. Pure.

Rule 1: each report is answered; once the formation is made, a robot that is in it is sent its pieces instead.
Rule 2 (liveness): it does not wait for reports to answer, but repeats its news: what is wanted of the robots
        that the view waits for, except of one that drives in its turn; and the formation for a short time.
"""

from collections.abc import Callable, Iterable, Set
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

    def act(
        self, odometry: Odometry, now_s: float, *, awaited: Callable[[], Set[int]], map_from: Set[int]
    ) -> list[Command]:
        """Answer all reports, and repeat news if it is time.

        Args:
            odometry: the newest.
            now_s: the time.
            awaited: finds the robots that the view waits for; of a thousand, too slowly for each event.
            map_from: whose map is wanted.
        """
        if is_due(last_s=self._news_at_s, every_s=self.timing.report_s, now_s=now_s):
            self._news_at_s = now_s
            drives = {self.turns.holder} if odometry.stood_s < self.timing.put_s else set[int]()
            self._due |= (awaited() & self.reported.counted.keys()) - drives
            if self.plan is not None and now_s - self._made_s <= NEWS_S:
                self._due.update(self.plan.order)
        plan, commands = self.plan, list[Command]()
        for robot in sorted(self._due):
            report = self.reported.said[robot]
            if plan is not None and robot in plan.members and plan.members[robot].life == report.life:
                commands += [Say(robot, piece) for piece in plan.pieces(robot)]
            else:
                commands.append(Say(robot, self._answer(robot, report, wants_map=robot in map_from)))
        self._due.clear()
        return commands

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
