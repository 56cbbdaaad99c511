"""The coordinator of a view: it hears the reports, gives the turns and makes the one formation. Pure.

Rule 1: it puts the next turn only when its own odometry has told this one, and each turn has one content
        (F4).
Rule 2: a formation is made once, from places that each were read from an odometry of a later turn than the
        last one that was put for that robot. After that it puts nothing but ALL.
Rule 3: a robot that is lost before that, or reports in another life, is dropped, and the draft begins again
        with the robots in place. It also begins again when another robot has reported. A draft begins only
        when no robot has a turn any more, and all places are newer than all turns. Otherwise a robot's view
        of its leg may show where another robot stood before its turn. Of two lives that have told the same
        turn nobody knows which is the older one, so the newest report may be late, and tell such a place.
Rule 4: what no message can tell has no place in the formation: robots without a place are told so.
Rule 5: it goes by phases (`agents.coordinating.phases`).
"""

from collections.abc import Mapping

from agents.commands import Command, Note
from agents.coordinating.agreeing import Agreement, Intent
from agents.coordinating.draft import Draft, NoTurn
from agents.coordinating.drafted import Drafted, drafted
from agents.coordinating.formation import Plan
from agents.coordinating.phases import PHASES, Phase
from agents.coordinating.questions import Questions
from agents.coordinating.reported import Reported
from agents.coordinating.telling import Telling
from agents.coordinating.turns import Turns
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from protocol.fence import Epoch, Fence, May
from protocol.mission import Mission
from protocol.wire.codec import fits
from protocol.wire.messages import Odometry
from protocol.wire.view import Join, Report

SLOW_PENALTY = 2.0  # for a robot that does nothing in its turn: it is left out for half a minute


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
        now_s: float,
    ) -> None:
        self._robot = robot
        self._epoch = epoch
        self._mission = mission
        self._timing = timing
        self._suspicion = suspicion
        self._agreement = Agreement(robot, epoch, intent, mission.goal is None, mission.path_bounds)
        self._began_s = now_s
        self._questions = Questions(mission, timing)
        self.phase = Phase.GATHERING
        self._reported = Reported(suspicion, now_s)
        self._reports: Mapping[int, Report] = self._reported.counted
        self._has_news = False
        """Whether another robot has reported since the draft began."""
        self._draft: Draft | None = None
        self._turns = Turns(epoch, timing, now_s)
        self._telling = Telling(epoch, timing, self._reported, self._questions, self._turns)
        self._join: Join | None = None
        self._no_room: set[int] = set()
        """Who had no turn, since no message can say where the strand ends."""

    def hear(self, robot: int, report: Report, now_s: float) -> None:
        """Take in a report; it is answered at the next `act`, whatever it says."""
        known = self._reports.get(robot)
        if not self._reported.hear(robot, report, now_s, closed=self.phase is Phase.FORMED):
            return
        if known is not None and known.life != report.life:
            self._drop(robot)
        self._has_news = self._has_news or known is None
        self._reported.count(robot, report)
        self._questions.hear(robot, report.look)

    def drafted(self, now_s: float) -> Drafted:
        """What it has drafted; once the formation is made, that."""
        return drafted(self._mission.robots, self._draft, self._telling.plan, self._reported, now_s)

    def act(self, odometry: Odometry, now_s: float) -> list[Command]:
        """What is to be done now."""
        fence = odometry.fence
        self._turns.watch(odometry, now_s)
        commands: list[Command] = []
        if not self._turns.are_told(fence):
            commands += self._turns.repeat(now_s)
        elif self.phase is not Phase.FORMED:
            commands += self._go_on(fence, now_s)
        strand = [] if self._draft is None else self._draft.strand
        return commands + self._telling.act(odometry, now_s, strand=strand, join=self._join)

    # --- phases -------------------------------------------------------------------------------------

    def _enter(self, phase: Phase) -> None:
        assert phase in PHASES[self.phase], f"{self.phase} -> {phase}"
        self.phase = phase

    def _go_on(self, fence: Fence, now_s: float) -> list[Command]:
        for robot in self._reported.lost(self._robot, now_s):
            self._drop(robot)
        if self._robot not in self._reports:
            return []
        if self.phase is Phase.GATHERING and fence.may is May.ONE:
            return self._take_back(fence, now_s)  # nobody drives while a draft begins
        if self.phase is Phase.GATHERING and not self._waits_for_reports(now_s):
            is_first = self._turns.newest is None  # no place is older than a turn
            plan = self._agreement.turned(self._reports, turn=fence.turn + 1) if is_first else None
            if plan is not None:
                self._enter(Phase.CLOSING)
                return self._make(plan, fence, now_s)
            self._begin(now_s)
        if self.phase is Phase.LOOKING and self._questions.are_answered(now_s):
            draft = self._drafting
            if draft.order and draft.settle(self._reports, self._questions.sees):
                self._enter(Phase.TURNING)
            else:
                draft.begin(self._reports, self._questions.obstacle_m(self._reports))
                self._look_at_legs(draft, now_s)
        commands = self._take_turns(fence, now_s) if self.phase is Phase.TURNING else []
        closes = self.phase is Phase.CLOSING and fence.may is not May.ONE
        return commands + (self._close(fence, now_s) if closes else [])

    def _begin(self, now_s: float) -> None:
        """Begin a draft, or begin it again with those that are in place."""
        if self._draft is None:
            led = self._agreement.counters(self._reports).last_to_lead
            self._draft = Draft(self._mission, self._timing, self._agreement.intent.cause, led)
        if self._has_news:
            self._has_news = False
            self._draft.admit()
        self._enter(Phase.LOOKING)
        if self._mission.goal is None:
            self._draft.forget_order()
            turn = self._turns.number
            self._reported.ask(self._questions.ask_about_obstacles(self._reports, now_s, turn=turn))
        else:
            self._draft.begin(self._reports, {})
            self._look_at_legs(self._draft, now_s)

    def _look_at_legs(self, draft: Draft, now_s: float) -> None:
        turn, keeps = self._turns.number, draft.keeps
        asked = self._questions.ask_about_legs(draft.order, self._reports, now_s, turn=turn, keeps=keeps)
        self._reported.ask(asked)

    @property
    def _drafting(self) -> Draft:
        assert self._draft is not None, "a draft has begun in all phases but the first"
        return self._draft

    # --- turns --------------------------------------------------------------------------------------

    def _take_turns(self, fence: Fence, now_s: float) -> list[Command]:
        draft = self._drafting
        if fence.may is May.ONE and not self._has_ended(fence, now_s):
            return []
        if self._has_news and self.phase is Phase.TURNING:
            self._enter(Phase.GATHERING)
        if self.phase is Phase.GATHERING or self._reported.owes_place(self._robot, self._turns):
            return self._take_back(fence, now_s)
        gone_s = now_s - self._timing.comes_back_s
        others_may_come_back = not self._reported.others_have_gone(self._mission.robots, gone_s)
        next_ = draft.next(self._reports, now_s, others_may_come_back=others_may_come_back)
        match next_:
            case int(robot):
                join = draft.join(robot, self._reports, fence.turn + 1)
                if fits(join):
                    self._join = join
                    self._reported.ask({robot})
                    life = self._reports[robot].life
                    return self._turns.put(fence, now_s, may=May.ONE, robot=robot, life=life)
                self._no_room.add(robot)
                draft.end_turn(robot, placed=False)
            case NoTurn.BEGIN:
                self._enter(Phase.GATHERING)
            case NoTurn.DONE:
                self._enter(Phase.CLOSING)
            case NoTurn.WAIT:
                pass
        return self._take_back(fence, now_s)

    def _take_back(self, fence: Fence, now_s: float) -> list[Command]:
        """Nobody has the turn any more."""
        return self._turns.put(fence, now_s, may=May.NOBODY) if fence.may is May.ONE else []

    def _has_ended(self, fence: Fence, now_s: float) -> bool:
        """Whether the turn is over: the robot has said so, or has been idle for too long."""
        report = self._reports[fence.robot]
        if report.ended >= fence.turn:
            self._drafting.end_turn(fence.robot, placed=report.placed)
            return True
        if self._turns.idle_s <= self._timing.turn_s or not self._suspicion.judges(now_s):
            return False
        if fence.robot == self._robot:
            self._drafting.end_turn(self._robot, placed=False)
        else:
            self._suspicion.blame(fence.robot, now_s, penalty=SLOW_PENALTY)
            self._drop(fence.robot)
        return True

    # --- the formation ------------------------------------------------------------------------------

    def _close(self, fence: Fence, now_s: float) -> list[Command]:
        """Rule 2."""
        draft = self._drafting
        if self._reported.waits_for_places(draft.strand, self._turns):
            return []
        if not self._telling.has_map(draft.strand[0], now_s):
            return []
        plan = self._agreement.drafted(draft.strand, draft.legs, self._reports, turn=fence.turn + 1)
        no_room = self._no_room.union(draft.strand).difference(plan.order)
        stranded = self._agreement.stranded(plan, self._reports, frozenset(no_room))
        return stranded + self._make(plan, fence, now_s)

    def _waits_for_reports(self, now_s: float) -> bool:
        """Whether robots are still waited for; a draft does not wait for long for one that is not heard."""
        timing = self._timing
        for robot in self._reported.overdue(self._robot, self._turns, now_s, after_s=timing.coordinator_s):
            self._drop(robot)
        is_late = now_s - self._began_s > timing.reports_s
        return self._reported.expects(self._turns, now_s, is_late=is_late)

    def _make(self, plan: Plan, fence: Fence, now_s: float) -> list[Command]:
        self._enter(Phase.FORMED)
        told, order = self._telling.tell(plan, now_s), plan.order
        put = self._turns.put(fence, now_s, may=May.ALL, robot=order[0], members=len(order))
        return [Note(plan.as_record()), *told, *put]

    # --- who is there ---------------------------------------------------------------------------------

    def _drop(self, robot: int) -> None:
        """Rule 3."""
        self._reported.drop(robot)
        if self._draft is not None:
            self._draft.drop(robot)
        if self.phase is not Phase.GATHERING:
            self._enter(Phase.GATHERING)
