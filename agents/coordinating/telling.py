"""What a coordinator tells the robots of its view: answers to reports, and news. Pure.

Rule 1: each report is answered; once the formation is made, a robot that is in it is sent its pieces instead.
Rule 2 (liveness): it does not wait for reports to answer, but repeats its news: a question until it is
        answered; the end of the strand until the robot that has the turn moves; the formation for a short
        time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from agents.commands import Command, Say
from agents.coordinating.agreeing import newest_map
from agents.coordinating.formation import Plan
from agents.coordinating.questions import Questions
from agents.coordinating.reported import Reported
from agents.coordinating.turns import Turns
from agents.due import is_due
from agents.liveness.timing import Timing
from protocol.fence import Epoch, May
from protocol.wire.messages import Odometry
from protocol.wire.view import Answer, Join, Report

NEWS_S = 1.0  # ten times: at 75 % loss a formation arrives in 94 % of cases; then it is asked for


@dataclass(slots=True)
class Telling:
    """The messages of one coordinator."""

    epoch: Epoch
    timing: Timing
    reported: Reported
    questions: Questions
    turns: Turns
    plan: Plan | None = None
    """The formation, once it is made."""
    _made_s: float = -float("inf")
    _news_at_s: float = -float("inf")
    _asks_map_since_s: float | None = None

    def tell(self, plan: Plan, now_s: float) -> list[Command]:
        """The formation is made: send it to its members."""
        stranded = (self.turns.had & self.reported.counted.keys()) - plan.lives.keys()
        self.plan = plan = replace(plan, stranded=tuple(sorted(stranded)))
        self._made_s = self._news_at_s = now_s
        self.reported.told(plan.order)
        return [Say(robot, piece) for robot in plan.order for piece in plan.pieces(robot)]

    def has_map(self, leader: int, now_s: float) -> bool:
        """Whether the newest map is here, or the leader has it, or it has not come for too long.

        Else it is asked for from now on.
        """
        counted = self.reported.counted
        newest = newest_map(counted)
        if newest.map_number <= counted[leader].map_number or newest.seen is not None:
            return True
        if self._asks_map_since_s is None:
            self._asks_map_since_s = now_s
            self.reported.ask(counted)
        return now_s - self._asks_map_since_s > self.timing.looks_s

    def act(
        self, odometry: Odometry, now_s: float, *, strand: Sequence[int], join: Join | None
    ) -> list[Command]:
        """Answer all reports, and repeat news if it is time.

        Args:
            odometry: the coordinator's newest.
            now_s: the time.
            strand: who is in place in the draft, leader first.
            join: what the robot that has the turn is to know.
        """
        if is_due(last_s=self._news_at_s, every_s=self.timing.report_s, now_s=now_s):
            self._news_at_s = now_s
            self.reported.ask(self._hear_no_news(odometry, now_s))
        commands: list[Command] = []
        for robot in self.reported.take_due():
            report = self.reported.said[robot]
            if self.plan is not None and self.plan.lives.get(robot) == report.life:
                commands += [Say(robot, piece) for piece in self.plan.pieces(robot)]
            else:
                rank = strand.index(robot) if robot in strand else None
                commands.append(Say(robot, self._answer(robot, report, rank, join)))
        return commands

    def _hear_no_news(self, odometry: Odometry, now_s: float) -> set[int]:
        """Rule 2: the robots that may not have heard their news."""
        counted = self.reported.counted
        if self.plan is not None:
            return set(self.plan.order) if now_s - self._made_s <= NEWS_S else set()
        all_stand = odometry.stood_s >= self.timing.put_s
        named = {odometry.fence.robot} & counted.keys() if all_stand else set()
        return named | {robot for robot in counted if self.questions.pending(robot) is not None}

    def _answer(self, robot: int, report: Report, rank: int | None, join: Join | None) -> Answer:
        put, counted = self.turns.newest, self.reported.counted
        has_turn = put is not None and (put.may, put.robot) == (May.ONE, robot)
        return Answer(
            epoch=self.epoch,
            life=report.life,
            heard=report.number,
            after_turn=self.turns.put_for(robot),
            out=self.plan is not None,
            question=None if has_turn else self.questions.pending(robot),  # a message has room for one
            join=join if has_turn else None,
            rank=rank,
            wants_map=self._asks_map_since_s is not None and newest_map(counted) == report,
        )
