"""The coordinator of a view: it hears the reports, gives the turns and makes the one formation. Pure.

Rule 1: it puts the next turn only when its own odometry has told this one, and one content for each (F4).
Rule 2: a formation is made once, from places that each were read from an odometry of a later turn than the
        last one that was put for that robot. After that it puts nothing but ALL.
Rule 3: a robot that is lost before that is dropped, and the draft begins again with those in place; it does
        so, too, when another robot has reported. It begins when nobody has a turn any more, and all places
        are newer than all turns. Else what robots see of their legs may be of where a robot stood before its
        turn.
Rule 4: it goes by phases (`agents.coordinating.phases`).
Rule 5 (liveness): it repeats a question until it is answered, where the strand ends until the robot that has
        the turn moves, and the formation for a moment: it does not wait for reports to answer.
"""

from collections.abc import Iterable, Iterator, Mapping

from agents.commands import Command, Note, Say
from agents.coordinating.agreeing import Agreement, Intent, newest_map
from agents.coordinating.draft import Begin, Done, Draft, Give, places_of
from agents.coordinating.formation import Plan
from agents.coordinating.legs import line_of
from agents.coordinating.order import positions
from agents.coordinating.phases import PHASES, Phase
from agents.coordinating.questions import Questions, points
from agents.coordinating.turns import Turns
from agents.due import is_due
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from protocol.fence import Cause, Epoch, Fence, May
from protocol.frames import Point
from protocol.mission import Mission
from protocol.timeline import RobotStranded
from protocol.wire.messages import Odometry
from protocol.wire.view import Answer, Join, Report

SLOW_PENALTY = 2.0  # for a robot that does nothing in its turn: it is left out for half a minute
NEWS_S = 1.0  # ten times: at 75 % loss a formation arrives in 94 % of cases; then it is asked for
NO_WAY = "it finds no way to a place behind the others"


class Coordinator:
    """One robot's role in the view that it has proposed."""

    def __init__(
        self,
        robot: int,
        epoch: Epoch,
        *,
        mission: Mission,
        timing: Timing,
        suspicion: Suspicion,
        intent: Intent,
        neighbours: Mapping[int, Point],
        now_s: float,
    ) -> None:
        self._robot = robot
        self._epoch = epoch
        self._mission = mission
        self._timing = timing
        self._suspicion = suspicion
        self._agreement = Agreement(robot, epoch, intent, mission.goal is None, neighbours)
        self._cause = intent.cause
        self._began_s = self._moved_s = self._looked_s = self._news_at_s = self._made_s = now_s
        self._questions = Questions(mission, timing)
        self.phase = Phase.GATHERING
        self.plan: Plan | None = None
        """The formation, once it is made."""
        self._reports: dict[int, Report] = {}
        self._heard_s: dict[int, float] = {}
        self._said: dict[int, Report] = {}
        """What anybody has said last, also who is not counted or comes too late."""
        self._due: set[int] = set()
        """Who is to be answered."""
        self._has_news = False
        """Whether another robot has reported since the draft began."""
        self._draft: Draft | None = None
        self._turns = Turns(epoch, timing, now_s)
        self._asks_map_since_s: float | None = None
        self._join: Join | None = None

    def hear(self, robot: int, report: Report, now_s: float) -> None:
        """Take in a report; it is answered at the next `act`, whatever it says."""
        known = self._reports.get(robot)
        if known is not None and known.life != report.life and report.turn < known.turn:
            return  # it is of an older life, and comes late
        self._due.add(robot)
        self._heard_s[robot], self._said[robot] = now_s, report
        if self.phase is Phase.FORMED or robot in self._suspicion.suppressed(now_s):
            return
        if known is not None and known.life == report.life and known.number >= report.number:
            return
        if known is not None and known.life != report.life:
            self._drop(robot)
        self._has_news = self._has_news or known is None
        self._reports[robot] = report
        self._questions.hear(robot, report.look)

    @property
    def reported(self) -> frozenset[int]:
        """Whose reports count."""
        return frozenset(self._reports)

    @property
    def stranded(self) -> frozenset[int]:
        """Who has reported, and found no way to a place in the formation."""
        return frozenset() if self.plan is None else frozenset(self._reports) - set(self.plan.order)

    def act(self, odometry: Odometry, now_s: float) -> list[Command]:
        """What is to be done now."""
        fence = odometry.fence
        if odometry.moving or odometry.stood_s < self._timing.put_s:
            self._moved_s = now_s
        commands: list[Command] = []
        if not self._turns.are_told(fence):
            commands += self._turns.repeat(now_s)
        elif self.phase is not Phase.FORMED:
            commands += self._go_on(fence, now_s)
        return commands + list(self._answers(odometry, now_s))

    # --- phases -------------------------------------------------------------------------------------

    def _enter(self, phase: Phase) -> None:
        assert phase in PHASES[self.phase], f"{self.phase} -> {phase}"
        self.phase = phase

    def _go_on(self, fence: Fence, now_s: float) -> list[Command]:
        commands: list[Command] = []
        self._drop_lost(now_s)
        if self._robot not in self._reports:
            return commands
        if self.phase is Phase.GATHERING and fence.may is May.ONE:
            return self._turns.put(fence, now_s, may=May.NOBODY)  # nobody drives while a draft begins
        if self.phase is Phase.GATHERING and not self._expects(now_s):
            is_first = self._turns.newest is None  # no place is older than a turn
            plan = self._agreement.turned(self._reports, turn=fence.turn + 1) if is_first else None
            if plan is not None:
                self._enter(Phase.CLOSING)
                return self._make(plan, fence, now_s)
            self._begin(now_s)
        if self.phase is Phase.LOOKING and self._questions.are_answered(now_s):
            assert self._draft is not None
            if self._draft.order and self._draft.settle(self._reports, self._questions.sees):
                self._enter(Phase.TURNING)
            else:
                self._draft.begin(self._reports, self._questions.obstacle_m(self._reports))
                self._look_at_legs(now_s)
        if self.phase is Phase.TURNING:
            commands += self._take_turns(fence, now_s)
        if self.phase is Phase.CLOSING:
            commands += self._close(fence, now_s)
        return commands

    def _expects(self, now_s: float) -> bool:
        """Whether robots are still waited for: their reports, or newer ones than their own last turns."""
        self._drop_silent(now_s)
        if self._waits_for_places(self._reports):
            return True
        if self._suspicion.judges(now_s) and now_s - self._began_s > self._timing.reports_s:
            return False
        showing = self._suspicion.presence.robots | {self._robot}
        expected = showing - self._suspicion.suppressed(now_s)
        return not expected <= self._reports.keys()

    def _begin(self, now_s: float) -> None:
        """Begin a draft, or begin it again with those that are in place."""
        if self._draft is None:
            led = self._agreement.counters(self._reports).led_in_vain
            self._draft = Draft(
                self._mission,
                self._timing,
                keeps=self._cause is not Cause.BLOCKED,
                first=self._cause is Cause.START,
                lets_in=self._cause is Cause.PLEA,
                led=led,
            )
        if self._has_news:
            self._has_news = False
            self._draft.admit()
        self._enter(Phase.LOOKING)
        if self._mission.goal is None:
            self._draft.forget_order()
            self._due.update(self._questions.ask_about_obstacles(self._reports, now_s))
        else:
            self._draft.begin(self._reports, {})
            self._look_at_legs(now_s)

    def _look_at_legs(self, now_s: float) -> None:
        draft = self._draft
        assert draft is not None
        self._due.update(self._questions.ask_about_legs(draft.order, self._reports, now_s, keeps=draft.keeps))

    # --- turns --------------------------------------------------------------------------------------

    def _take_turns(self, fence: Fence, now_s: float) -> list[Command]:
        draft = self._draft
        assert draft is not None
        if fence.may is May.ONE and not self._has_ended(fence, now_s):
            return []
        if self._has_news and self.phase is Phase.TURNING:
            self._enter(Phase.GATHERING)
        if self.phase is Phase.GATHERING:
            return self._turns.put(fence, now_s, may=May.NOBODY) if fence.may is May.ONE else []
        next_ = draft.next(self._reports, now_s, others_may_come_back=self._others_may_come_back(now_s))
        commands: list[Command] = []
        if not isinstance(next_, Give) and fence.may is May.ONE:
            commands += self._turns.put(fence, now_s, may=May.NOBODY)
        match next_:
            case Give(robot, makes_way):
                self._join = self._join_for(robot, fence.turn + 1, makes_way=makes_way)
                self._moved_s = now_s
                self._due.add(robot)
                life = self._reports[robot].life
                return self._turns.put(fence, now_s, may=May.ONE, robot=robot, life=life)
            case Begin():
                self._enter(Phase.GATHERING)
            case Done():
                self._enter(Phase.CLOSING)
            case _:
                pass
        return commands

    def _has_ended(self, fence: Fence, now_s: float) -> bool:
        """Whether the turn is over: the robot has said so, is no more, or has done nothing for too long."""
        draft, report = self._draft, self._reports.get(fence.robot)
        assert draft is not None
        if report is None or report.life != fence.life:
            return True
        if report.ended >= fence.turn:
            draft.end_turn(fence.robot, placed=report.placed)
            return True
        if now_s - self._moved_s <= self._timing.turn_s or not self._suspicion.judges(now_s):
            return False
        if fence.robot != self._robot:
            self._suspicion.blame(fence.robot, now_s, penalty=SLOW_PENALTY)
            self._drop(fence.robot)
        return True

    def _join_for(self, robot: int, turn: int, *, makes_way: bool) -> Join:
        assert self._draft is not None
        strand, places = self._draft.strand, places_of(self._reports)
        line, leg = line_of(places, strand, self._draft.legs)
        waiting = [other for other in places if other != robot and (makes_way or other not in strand)]
        return Join(
            turn=turn,
            strand=points(positions(places, strand)) if not makes_way else (),
            waiting=points(positions(places, waiting)),
            line=points(line),
            last_leg=int((leg == leg[-1]).sum()) if len(leg) else 0,
            makes_way=makes_way,
        )

    def _others_may_come_back(self, now_s: float) -> bool:
        outside = set(range(1, self._mission.robots + 1)) - self._reports.keys()
        went_by_s = now_s - self._timing.comes_back_s
        return not all(self._suspicion.presence.has_gone_by(robot, went_by_s) for robot in outside)

    # --- the formation ------------------------------------------------------------------------------

    def _close(self, fence: Fence, now_s: float) -> list[Command]:
        """Rule 2."""
        draft = self._draft
        assert draft is not None
        if fence.may is May.ONE:
            return self._turns.put(fence, now_s, may=May.NOBODY)
        if self._waits_for_places(draft.strand):
            return []
        if not self._has_map(draft.strand[0], now_s):
            return []
        driven = frozenset(draft.driven)
        plan = self._agreement.drafted(draft.strand, draft.legs, driven, self._reports, turn=fence.turn + 1)
        stranded: list[Command] = [
            Note(
                RobotStranded(
                    epoch=self._epoch.number,
                    robot=robot,
                    reason=NO_WAY,
                    by=self._agreement.in_the_way(robot, draft.strand[-1], self._reports),
                )
            )
            for robot in sorted(self._reports.keys() - set(plan.order))
        ]
        return stranded + self._make(plan, fence, now_s)

    def _old(self, robots: Iterable[int]) -> set[int]:
        """The robots of these whose place may be older than their own last turn."""
        return {robot for robot in robots if self._reports[robot].turn <= self._turns.put_for(robot) > 0}

    def _waits_for_places(self, robots: Iterable[int]) -> bool:
        """Whether the place of one of these may be old; each such one is asked."""
        old = self._old(robots)
        self._due |= old
        return bool(old)

    def _drop_silent(self, now_s: float) -> None:
        """A draft does not wait for long for the place of a robot that is not heard."""
        if not self._suspicion.judges(now_s):
            return
        for robot in self._old(self._reports.keys() - {self._robot}):
            if now_s - self._heard_s[robot] > self._timing.coordinator_s:
                self._drop(robot)

    def _make(self, plan: Plan, fence: Fence, now_s: float) -> list[Command]:
        self._enter(Phase.FORMED)
        self.plan = plan
        self._made_s = self._news_at_s = now_s
        told = [Say(robot, piece) for robot in plan.order for piece in plan.pieces(robot)]
        self._due -= set(plan.order)
        order = plan.order
        put = self._turns.put(fence, now_s, may=May.ALL, robot=order[0], members=len(order))
        return [Note(plan.as_record()), *told, *put]

    def _has_map(self, leader: int, now_s: float) -> bool:
        """Whether the newest map is here, or the leader has it, or it has not come for too long."""
        newest = newest_map(self._reports)
        if newest.map_number <= self._reports[leader].map_number or newest.seen is not None:
            return True
        if self._asks_map_since_s is None:
            self._asks_map_since_s = now_s
            self._due |= self._reports.keys()
        return now_s - self._asks_map_since_s > self._timing.looks_s

    # --- answers ------------------------------------------------------------------------------------

    def _answers(self, odometry: Odometry, now_s: float) -> Iterator[Command]:
        if is_due(last_s=self._news_at_s, every_s=self._timing.report_s, now_s=now_s):
            self._news_at_s = now_s
            self._due |= self._told_news(odometry, now_s)
        for robot in sorted(self._due):
            report = self._said[robot]
            if self.plan is not None and self.plan.lives.get(robot) == report.life:
                yield from (Say(robot, piece) for piece in self.plan.pieces(robot))
            else:
                yield Say(robot, self._answer(robot, report))
        self._due.clear()

    def _told_news(self, odometry: Odometry, now_s: float) -> set[int]:
        """Rule 5: who may not have heard its news."""
        if self.plan is not None:
            return set(self.plan.order) if now_s - self._made_s <= NEWS_S else set()
        fence = odometry.fence
        named = {fence.robot} & self._reports.keys() if not odometry.moving else set()
        return named | {robot for robot in self._reports if self._questions.pending(robot) is not None}

    def _answer(self, robot: int, report: Report) -> Answer:
        draft = self._draft
        strand = draft.strand if draft is not None else []
        put = self._turns.newest
        has_turn = put is not None and (put.may, put.robot) == (May.ONE, robot)
        return Answer(
            epoch=self._epoch,
            life=report.life,
            heard=report.number,
            after_turn=self._turns.put_for(robot),
            out=self.plan is not None or robot not in self._reports,
            stranded=self.plan is not None and robot in self._reports,
            question=self._questions.pending(robot),
            join=self._join if has_turn else None,
            rank=strand.index(robot) if robot in strand else None,
            wants_map=self._asks_map_since_s is not None and newest_map(self._reports) == report,
        )

    # --- who is there ---------------------------------------------------------------------------------

    def _drop_lost(self, now_s: float) -> None:
        """Rule 3; once for all that is heard at the same time."""
        if now_s == self._looked_s:
            return
        self._looked_s = now_s
        for robot in sorted(self._reports):
            gone = self._suspicion.has_gone(robot, self._heard_s[robot], now_s)
            if robot != self._robot and gone:
                self._drop(robot)

    def _drop(self, robot: int) -> None:
        del self._reports[robot]
        self._questions.forget({robot})
        if self._draft is not None and self.phase is not Phase.FORMED:
            self._draft.drop(robot)
            if self.phase is not Phase.GATHERING:
                self._enter(Phase.GATHERING)
