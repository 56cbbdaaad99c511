"""The coordinator of a view: it hears the reports, gives the turns and makes the one formation. Pure.

Rule 1: it puts the next turn only when its own odometry has told this one, and each turn has one content
        (F4). It gives no turn while its own place may be older than its own last turn: the robot that has
        the turn takes hits at that place for the coordinator's hull (F6b).
Rule 2: a formation is made once, from places that each were read from an odometry of a later turn than the
        last one that was put for that robot. After that it puts nothing but ALL.
Rule 3: a robot that is lost before that, or reports in another life, is dropped, and the draft begins again
        with the robots in place. So is one that is silent while the view waits for its place. The draft also
        begins again when another robot has reported. It begins only when no robot has a turn any more, and
        all places are newer than all turns. Otherwise what a robot sees on its leg may be from before another
        robot's turn. Of two lives that have told the same turn nobody knows which is older, so the newest
        report may be late, and tell such a place.
Rule 4: what no message can tell has no place in the formation: robots without a place are told so.
Rule 5: it goes by phases (`agents.coordinating.phases`). A phase ends when it waits for no robot any more.
"""

from collections.abc import Collection, Mapping, Set
from functools import partial

from agents.commands import Command, Note
from agents.coordinating.agreeing import Agreement, Intent
from agents.coordinating.draft import Draft, Drafted, NoTurn
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
from protocol.wire.view import Report

SLOW_PENALTY = 2.0  # for a robot that does nothing in its turn: it is left out for half a minute


class Coordinator:
    """One robot's role in the view that it has proposed."""

    def __init__(
        self,
        epoch: Epoch,
        *,
        mission: Mission,
        timing: Timing,
        suspicion: Suspicion,
        intent: Intent,
        now_s: float,
    ) -> None:
        self._robot = epoch.robot
        self._timing = timing
        self._suspicion = suspicion
        self._began_s = now_s
        self.phase = Phase.GATHERING
        self._since_s = now_s
        """When its phase began."""
        self._questions = Questions(mission, timing)
        self._reports: dict[int, Report] = {}
        """Those that count."""
        self._reported = Reported(suspicion, mission.robots, self._reports, now_s)
        self._turns = Turns(Fence(epoch=epoch), timing, now_s)
        self._agreement = Agreement(epoch, intent, mission, self._reports, self._turns.put_for)
        self._draft = Draft(mission, intent.cause)
        self._telling = Telling(timing, self._reported, self._questions, self._turns, self._draft)
        self._no_room: set[int] = set()
        """The robots that had no turn, since no message can say where the strand ends."""

    def hear(self, robot: int, report: Report, now_s: float) -> None:
        """Take in a report; it is answered at the next `act`, whatever it says."""
        if self._reported.is_late(robot, report):
            return
        self._telling.ask({robot})
        if not self._reported.hear(robot, report, now_s) or self.phase is Phase.FORMED:
            return
        known = self._reports.get(robot)
        if known is not None and known.life != report.life:
            self._drop(robot, now_s)
        self._reports[robot] = report
        self._questions.hear(robot, report.look)

    def drafted(self, now_s: float) -> Drafted:
        """What it has drafted; once the formation is made, that."""
        plan, draft = self._telling.plan, self._draft
        in_place = draft.strand if plan is None else plan.order
        why = self._reported.left_out(in_place, draft.tried, now_s)
        return Drafted(draft.order, in_place, why, self._awaited(now_s), self._since_s)

    def act(self, odometry: Odometry, now_s: float) -> list[Command]:
        """What is to be done now."""
        fence = odometry.fence
        self._turns.watch(odometry, now_s)
        commands: list[Command] = []
        if not self._turns.are_told(fence):
            commands += self._turns.repeat(now_s)
        elif self.phase is not Phase.FORMED:
            commands += self._go_on(fence, now_s)
        awaited = partial(self._awaited, now_s)
        return commands + self._telling.act(odometry, now_s, awaited=awaited, map_from=self._map_from)

    # --- phases -------------------------------------------------------------------------------------

    def _enter(self, phase: Phase, now_s: float) -> None:
        assert phase in PHASES[self.phase], f"{self.phase} -> {phase}"
        self.phase, self._since_s = phase, now_s

    def _awaited(self, now_s: float) -> Set[int]:
        """The robots that the view waits for in its phase."""
        match self.phase:
            case Phase.GATHERING:
                is_late = now_s - self._began_s > self._timing.reports_s and self._suspicion.judges(now_s)
                return self._owing or (frozenset() if is_late else self._reported.unheard(now_s))
            case Phase.LOOKING:
                return self._questions.awaited(now_s)
            case Phase.TURNING:
                holder = self._turns.holder
                return {holder} if holder else self._owing or self._may_come_back(now_s)
            case Phase.CLOSING:
                is_late = now_s - self._since_s > self._timing.looks_s
                untold = {robot for robot in self._map_from if self._reports[robot].seen is None}
                return self._owing if is_late else self._owing | untold
            case Phase.FORMED:
                return frozenset()

    @property
    def _owing(self) -> Set[int]:
        """The robots that have yet to tell this phase a place that is newer than their own last turn."""
        owed: dict[Phase, Collection[int]] = {
            Phase.GATHERING: self._reports.keys(),
            Phase.TURNING: {self._robot},
            Phase.CLOSING: self._draft.strand,
        }
        return self._reported.old(owed.get(self.phase, ()), self._turns)

    def _may_come_back(self, now_s: float) -> Set[int]:
        """The robots that were there lately; none once the view has lasted for `comes_back_s`."""
        since_s = now_s - self._timing.comes_back_s
        return self._reported.missing(since_s) if self._began_s > since_s else frozenset()

    @property
    def _map_from(self) -> Set[int]:
        """CLOSING: the robot that is to tell its map, if the leader has an older one."""
        closes = self.phase is Phase.CLOSING
        return self._agreement.newer_map(self._draft.strand[0]) if closes else frozenset()

    def _go_on(self, fence: Fence, now_s: float) -> list[Command]:
        # Silence counts from the phase's begin on: while a robot drove, it had nothing to report.
        silent_s = self._timing.looks_s
        owing = self._owing if now_s - self._since_s > silent_s else frozenset()
        for robot in self._reported.lost(self._robot, now_s, owing=owing, silent_s=silent_s):
            self._drop(robot, now_s)
        if self._robot not in self._reports:
            return []
        if self.phase is Phase.GATHERING and fence.may is May.ONE:
            return self._take_back(fence, now_s)  # nobody drives while a draft begins
        if self.phase is Phase.GATHERING and not self._awaited(now_s):
            is_first = self._turns.newest.turn == 0  # no place is older than a turn
            plan = self._agreement.turned(turn=fence.turn + 1) if is_first else None
            if plan is not None:
                self._enter(Phase.CLOSING, now_s)
                return self._make(plan, fence, now_s)
            self._enter(Phase.LOOKING, now_s)
            self._look({}, now_s)
        if self.phase is Phase.LOOKING and not self._awaited(now_s):
            if self._draft.order and self._draft.settle(self._reports, self._questions.sees):
                self._enter(Phase.TURNING, now_s)
            else:
                self._look(self._questions.obstacle_m(self._reports), now_s)
        commands = self._take_turns(fence, now_s) if self.phase is Phase.TURNING else []
        closes = self.phase is Phase.CLOSING and fence.may is not May.ONE and not self._awaited(now_s)
        return commands + (self._close(fence, now_s) if closes else [])

    def _drop(self, robot: int, now_s: float) -> None:
        """Rule 3."""
        del self._reports[robot]
        self._draft.drop(robot)
        if self.phase is not Phase.GATHERING:
            self._enter(Phase.GATHERING, now_s)

    def _look(self, obstacle_m: Mapping[int, float], now_s: float) -> None:
        """Ask robots to look at the legs of the next order; without a goal, first at what is near them."""
        draft, reports, turn = self._draft, self._reports, self._turns.newest.turn
        draft.begin(reports, obstacle_m, self._agreement.counters().last_to_lead)
        asked = self._questions.ask(draft.order, reports, now_s, turn=turn, keeps=draft.keeps)
        self._telling.ask(asked)

    # --- turns --------------------------------------------------------------------------------------

    def _take_turns(self, fence: Fence, now_s: float) -> list[Command]:
        draft, reports = self._draft, self._reports
        if fence.may is May.ONE and not self._has_ended(fence, now_s):
            return []
        if self.phase is Phase.TURNING and reports.keys() - {*draft.order}:  # another robot has reported
            self._enter(Phase.GATHERING, now_s)
        if self.phase is Phase.GATHERING or self._owing:
            return self._take_back(fence, now_s)  # the next robot is to know where this one stands
        match draft.next(reports, others_may_come_back=bool(self._may_come_back(now_s))):
            case int(robot):
                join = draft.join(robot, reports, fence.turn + 1)
                if fits(join):
                    self._telling.give_turn(robot, join)
                    life = reports[robot].life
                    return self._turns.put(fence, now_s, may=May.ONE, robot=robot, life=life)
                self._no_room.add(robot)
                draft.end_turn(robot, placed=False)
            case NoTurn.BEGIN:
                self._enter(Phase.GATHERING, now_s)
            case NoTurn.DONE:
                self._enter(Phase.CLOSING, now_s)
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
            self._draft.end_turn(fence.robot, placed=report.placed)
            return True
        if self._turns.idle_s <= self._timing.turn_s or not self._suspicion.judges(now_s):
            return False
        if fence.robot == self._robot:
            self._draft.end_turn(self._robot, placed=False)
        else:
            self._suspicion.blame(fence.robot, now_s, penalty=SLOW_PENALTY)
            self._drop(fence.robot, now_s)
        return True

    # --- the formation ------------------------------------------------------------------------------

    def _close(self, fence: Fence, now_s: float) -> list[Command]:
        """Rule 2."""
        strand = self._draft.strand
        plan = self._agreement.drafted(strand, self._draft.legs, turn=fence.turn + 1)
        no_room = self._no_room.union(strand).difference(plan.order)
        stranded = self._agreement.stranded(plan, no_room)
        return stranded + self._make(plan, fence, now_s)

    def _make(self, plan: Plan, fence: Fence, now_s: float) -> list[Command]:
        self._enter(Phase.FORMED, now_s)
        told, order = self._telling.tell(plan, now_s), plan.order
        put = self._turns.put(fence, now_s, may=May.ALL, robot=order[0], members=len(order))
        return [Note(plan.as_record()), *told, *put]
