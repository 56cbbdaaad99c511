"""What a bound robot reports to the coordinator, and how it answers the coordinator's questions.

Rule 1: it reports only while it stands, when its newest order has ended. It repeats a report until it is
        answered, and after that less often, since the answer shows that the coordinator is there.
Rule 2: it looks when it is asked to, from where it stands. A leg that has been driven is not looked at: a
        robot that drives on it takes a new scan (`agents.strand.follower`). It looks closer where a leg is
        clear of all hits, but not of what may be hidden between the rays.
"""

import math
from dataclasses import dataclass, field

from msgspec.structs import replace

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command, Say
from agents.due import is_due
from agents.liveness.timing import Timing
from agents.membership.assembly import Assembly
from agents.membership.legs import leg_is_clear, leg_needs_closer_look, without_hulls
from agents.membership.places import Past
from agents.membership.turn import Ended
from agents.strand.memory import Memory
from protocol.arrays import places_xy, xy
from protocol.fence import Epoch
from protocol.frames import Pose
from protocol.legs import off_place_m_max
from protocol.mission import Mission
from protocol.wire.view import Answer, Formation, Former, Join, Look, Report

NO_ANSWER, NO_TURN = Answer(epoch=Epoch(), life=0, heard=0), Ended(turn=0, placed=False)


@dataclass(slots=True)
class Reporter:
    """One robot's reports in one view."""

    epoch: Epoch
    life: int
    mission: Mission
    timing: Timing
    memory: Memory
    past: Past
    """With its places as of now."""
    heard_at_s: float
    """When the coordinator was heard last, or the view began."""
    answer: Answer = NO_ANSWER
    ended: Ended = NO_TURN
    """Its newest turn in this view."""
    formed_s: float = math.inf
    """When the first piece of the formation came."""
    assembly: Assembly = field(default_factory=Assembly)
    _said: Report | None = None
    _said_at_s: float = -float("inf")
    _formers: tuple[Past, Pose, tuple[Former, ...]] | None = None
    """What it has told last, of which places and from where."""
    _newest: int = -1
    _look: Look | None = None

    def hear(self, answer: Answer, number: int, now_s: float) -> None:
        """Take in the coordinator's answer; an older one than the newest changes nothing."""
        if number <= self._newest:
            return
        self._newest = number
        self.heard_at_s, self.answer = now_s, answer
        # Where another leader is tried nobody is in place; a robot that has had no turn still has its place.
        if answer.rank is not None or self.ended.turn > 0:
            self.past = self.past.with_draft(self.epoch, answer.rank)

    def join(self, turn: int) -> Join | None:
        """Where the strand ends, for this turn of the robot; None if it does not know, or has ended it."""
        join = self.answer.join
        return join if join is not None and join.turn == turn != self.ended.turn else None

    def hear_formation(self, piece: Formation, now_s: float) -> None:
        """A piece of the formation has come."""
        self.assembly.add(piece)
        self.heard_at_s = now_s
        self.formed_s = min(self.formed_s, now_s)

    def end_turn(self, ended: Ended) -> None:
        """The robot has ended a turn of its own, and stands."""
        self.ended = ended

    def leave_places(self) -> None:
        """The robot has driven by its own steps: it stands at none of its former places."""
        self.past = self.past.elsewhere()

    def act(self, driver: Driver, senses: Senses, now_s: float) -> list[Command]:
        """Look if asked to, and report; to be called while the robot stands."""
        commands = self._see(driver.odometry.pose, senses, now_s)
        report = self._report(driver)
        if self._said is None or replace(report, number=self._said.number) != self._said:
            number = 1 if self._said is None else self._said.number + 1
            self._said = replace(report, number=number)
        elif not is_due(last_s=self._said_at_s, every_s=self._every_s(self._said), now_s=now_s):
            return commands
        self._said_at_s = now_s
        return [*commands, Say(self.epoch.robot, self._said)]

    def _every_s(self, said: Report) -> float:
        """Rule 1."""
        is_answered = self.answer.heard >= said.number and self.heard_at_s >= self._said_at_s
        return self.timing.ping_s if is_answered else self.timing.report_s

    def _report(self, driver: Driver) -> Report:
        odometry, after, said = driver.odometry, self.answer.after_turn, self._said
        # Every turn is new to all, but news only to those whose place is older than their own last turn.
        fresh = said is None or (after > 0 and said.turn <= after) or said.place != odometry.pose
        return Report(
            epoch=self.epoch,
            life=self.life,
            number=0,
            turn=odometry.fence.turn if fresh or said is None else said.turn,
            place=odometry.pose,
            formers=self._told_formers(odometry.pose),
            look=self._look,
            ended=self.ended.turn,
            placed=self.ended.placed,
            map_number=self.memory.number,
            seen=self.memory.seen if self.answer.wants_map else None,
            arrived=self.past.arrived,
            counters=self.past.counters,
            counted=self.past.counted,
        )

    def _told_formers(self, pose: Pose) -> tuple[Former, ...]:
        """Where it stands on its former places. It is kept: a robot that stands tells the same each time."""
        past = self.past
        if self._formers is None or self._formers[0] is not past or self._formers[1] != pose:
            self._formers = past, pose, past.formers(pose)
        return self._formers[2]

    def _see(self, pose: Pose, senses: Senses, now_s: float) -> list[Command]:
        """Rule 2."""
        question = self.answer.question
        if question is None or (self._look is not None and self._look.number == question.number):
            return []
        if question.place is not None:
            off_m_max = off_place_m_max(self.mission)
            way = self.past.leg_to(question.formers, pose, question.place, off_m_max=off_m_max)
            if way is not None or not self.mission.promises_clearance:
                self._look = Look(number=question.number, clear=True, way=way or ())
                return []
        scan = senses.take()
        if scan is None:
            return senses.ask(now_s)
        seen = without_hulls(scan, places_xy(question.others), self.mission)
        if question.place is None:
            self._look = Look(number=question.number, obstacle_m=seen.nearest_m)
            return []
        ahead = xy(question.place)
        clear = leg_is_clear(seen, ahead, self.mission)
        if not clear and leg_needs_closer_look(seen, ahead, self.mission):
            senses.look_closer(scan)
            return senses.ask(now_s)
        self._look = Look(number=question.number, clear=clear)
        return []
