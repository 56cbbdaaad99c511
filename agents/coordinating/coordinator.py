"""The coordinator of a view: it hears the reports, gives the turns and makes the one formation. Pure.

Rule 1: it puts the next turn only when its own odometry has told this one, and one content for each (F4).
Rule 2: a formation is made once, from places that each were read from an odometry of a later turn than the
        last one that was put for that robot. After that it puts nothing but ALL.
Rule 3: a robot that is lost before that is dropped, and the draft begins again with those in place.
Rule 4: it goes by phases; `PHASES` says which may follow which.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType

from msgspec.structs import replace as changed

from agents.commands import Command, Note, Put, Say
from agents.coordinating.draft import Begin, Done, Draft, Give, places_of
from agents.coordinating.formation import Plan, lay_path
from agents.coordinating.legs import line_of
from agents.coordinating.order import positions
from agents.coordinating.questions import Questions, points
from agents.coordinating.turnabout import turned_round
from agents.due import is_due
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from agents.strand.wish import Turnabout
from protocol.fence import Cause, Epoch, Fence, May, Turn
from protocol.mission import Mission
from protocol.path import Path
from protocol.timeline import RobotStranded
from protocol.wire.messages import Odometry
from protocol.wire.view import Answer, Counters, Join, Report


SLOW_PENALTY = 2.0  # for a robot that does nothing in its turn: it is left out for half a minute


class Phase(StrEnum):
    """What the coordinator waits for."""

    GATHERING = "gathering"  # reports
    LOOKING = "looking"  # what robots see of their legs, or of the nearest obstacle
    TURNING = "turning"  # the end of a turn
    CLOSING = "closing"  # places that are newer than all turns, and the newest map
    FORMED = "formed"  # nothing: the formation is made


PHASES = MappingProxyType(
    {
        Phase.GATHERING: (Phase.LOOKING, Phase.CLOSING),
        Phase.LOOKING: (Phase.LOOKING, Phase.TURNING, Phase.GATHERING),
        Phase.TURNING: (Phase.LOOKING, Phase.CLOSING, Phase.GATHERING),
        Phase.CLOSING: (Phase.FORMED, Phase.LOOKING, Phase.GATHERING),
        Phase.FORMED: (),
    }
)


@dataclass(frozen=True, slots=True)
class Intent:
    """Why the view was proposed, and what its proposer knows of the last strand."""

    cause: Cause
    led_by: int = 0
    """Who led the last strand; 0: there was none."""
    turnabout: Turnabout | None = None
    """DEAD_END: how the strand is to turn round, in this epoch, of so many robots, on this path."""
    ended: Epoch | None = None
    robots: int = 0
    path: Path | None = None


class Coordinator:
    """One robot's role in the view that it has proposed."""

    def __init__(
        self,
        robot: int,
        epoch: Epoch,
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
        self._intent = intent
        self._began_s = self._moved_s = self._looked_s = now_s
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
        self._draft: Draft | None = None
        self._put: Fence | None = None
        self._put_at_s = now_s
        self._turn_of: dict[int, int] = {}
        """The last turn that was put for each robot."""
        self._asks_map_since_s: float | None = None
        self._join: Join | None = None

    def hear(self, robot: int, report: Report, now_s: float) -> None:
        """Take in a report; it is answered at the next `act`, whatever it says."""
        self._due.add(robot)
        self._heard_s[robot], self._said[robot] = now_s, report
        known = self._reports.get(robot)
        if self.phase is Phase.FORMED or robot in self._suspicion.suppressed(now_s):
            return
        if known is not None and known.life == report.life and known.number >= report.number:
            return
        if known is not None and known.life != report.life:
            self._drop(robot)
        self._reports[robot] = report
        self._questions.hear(robot, report.look)

    def act(self, odometry: Odometry, now_s: float) -> list[Command]:
        """What is to be done now."""
        fence = odometry.fence
        if odometry.moving or odometry.stood_s < self._timing.put_s:
            self._moved_s = now_s
        commands: list[Command] = []
        told = self._put is None or fence.turn >= self._put.turn
        if not told:
            commands += self._repeat(now_s)
        elif self.phase is not Phase.FORMED:
            commands += self._go_on(fence, now_s)
        return commands + list(self._answers())

    # --- phases -------------------------------------------------------------------------------------

    def _enter(self, phase: Phase) -> None:
        assert phase in PHASES[self.phase], f"{self.phase} -> {phase}"
        self.phase = phase

    def _go_on(self, fence: Fence, now_s: float) -> list[Command]:
        commands: list[Command] = []
        self._drop_lost(now_s)
        if self._robot not in self._reports:
            return commands
        if self.phase is Phase.GATHERING and not self._expects(now_s):
            plan = self._turned_round(fence)
            if plan is not None:
                self._enter(Phase.CLOSING)
                return self._make(plan)
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
        """Whether robots that show a token have not reported yet, and are still waited for."""
        if now_s - self._began_s > self._timing.reports_s:
            return False
        showing = self._suspicion.presence.robots | {self._robot}
        expected = showing - self._suspicion.suppressed(now_s)
        return not expected <= self._reports.keys()

    def _begin(self, now_s: float) -> None:
        """Begin a draft, or begin it again with those that are in place."""
        first = self._intent.cause is Cause.START
        if self._draft is None:
            keeps = self._intent.cause is not Cause.BLOCKED
            led = self._counters().led_in_vain
            self._draft = Draft(self._mission, self._timing, keeps=keeps, first=first, led=led)
        self._enter(Phase.LOOKING)
        if self._mission.goal is None:
            self._draft.order = ()
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
        if fence.may is May.ONE:
            report = self._reports.get(fence.robot)
            over = report is not None and report.ended >= fence.turn
            if report is not None and not over and now_s - self._moved_s <= self._timing.turn_s:
                return []
            if report is not None and over:
                draft.end_turn(fence.robot, placed=report.placed)
            elif report is not None and fence.robot != self._robot:
                self._suspicion.blame(fence.robot, now_s, penalty=SLOW_PENALTY)
                self._drop(fence.robot)
                return self._put_turn(fence, now_s, may=May.NOBODY)
        next_ = draft.next(self._reports, now_s, others_may_come_back=self._others_may_come_back(now_s))
        commands: list[Command] = []
        if not isinstance(next_, Give) and fence.may is May.ONE:
            commands += self._put_turn(fence, now_s, may=May.NOBODY)
        match next_:
            case Give(robot, makes_way):
                self._join = self._join_for(robot, fence.turn + 1, makes_way=makes_way)
                life = self._reports[robot].life
                return self._put_turn(fence, now_s, may=May.ONE, robot=robot, life=life)
            case Begin():
                self._begin(now_s)
            case Done():
                self._enter(Phase.CLOSING)
            case _:
                pass
        return commands

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

    def _put_turn(
        self, fence: Fence, now_s: float, *, may: May, robot: int = 0, life: int = 0, members: int = 0
    ) -> list[Command]:
        """Rule 1."""
        self._put = Fence(
            epoch=self._epoch, turn=fence.turn + 1, may=may, robot=robot, life=life, members=members
        )
        self._put_at_s, self._moved_s = now_s, now_s
        if may is May.ONE:
            self._turn_of[robot] = self._put.turn
            self._due.add(robot)
        return [Put(Turn(fence=self._put))]

    def _repeat(self, now_s: float) -> list[Command]:
        assert self._put is not None
        if not is_due(last_s=self._put_at_s, every_s=self._timing.put_s, now_s=now_s):
            return []
        self._put_at_s = now_s
        return [Put(Turn(fence=self._put))]

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
            return self._put_turn(fence, now_s, may=May.NOBODY)
        for robot in draft.strand:
            report = self._reports[robot]
            if report.turn <= self._turn_of.get(robot, -1):
                self._due.add(robot)
                return []
        if not self._has_map(draft.strand[0], now_s):
            return []
        order = tuple(draft.strand)
        path, places_m = lay_path(order, places_of(self._reports), draft.legs)
        plan = self._plan(fence, order, path, places_m, frozenset(draft.driven))
        stranded = [robot for robot in self._reports if robot not in order]
        commands: list[Command] = [
            Note(RobotStranded(epoch=self._epoch.number, robot=robot, reason="it finds no way to a place"))
            for robot in stranded
        ]
        return commands + self._make(plan)

    def _plan(
        self,
        fence: Fence,
        order: tuple[int, ...],
        path: Path,
        places_m: Mapping[int, float],
        driven: frozenset[int],
        *,
        back_by_m: float = 0.0,
    ) -> Plan:
        newest = self._newest_map()
        cause = self._intent.cause
        return Plan(
            epoch=self._epoch,
            turn=fence.turn + 1,
            order=order,
            lives={robot: self._reports[robot].life for robot in order},
            places={robot: self._reports[robot].place for robot in order},
            path=path,
            places_m=places_m,
            driven=driven,
            back_by_m=back_by_m,
            counters=self._counters(),
            heals=cause not in {Cause.START, Cause.BLOCKED, Cause.DEAD_END},
            led_by=self._intent.led_by,
            map_number=newest.map_number,
            seen=newest.seen if newest.map_number > self._reports[order[0]].map_number else None,
            sensed=self._mission.goal is None,
        )

    def _turned_round(self, fence: Fence) -> Plan | None:
        """The formation of a strand that turns round; None if this view does not, or not all are there."""
        intent = self._intent
        if intent.turnabout is None or intent.path is None or intent.ended is None:
            return None
        turned = turned_round(
            intent.turnabout, intent.path, self._reports, ended=intent.ended, robots=intent.robots
        )
        if turned is None:
            return None
        order, path, places_m = turned
        back_by_m = intent.turnabout.back_by_m
        return self._plan(fence, order, path, places_m, frozenset(order[1:]), back_by_m=back_by_m)

    def _make(self, plan: Plan) -> list[Command]:
        self._enter(Phase.FORMED)
        self.plan = plan
        self._put = Fence(
            epoch=self._epoch, turn=plan.turn, may=May.ALL, robot=plan.order[0], members=len(plan.order)
        )
        told = [Say(robot, piece) for robot in plan.order for piece in plan.pieces(robot)]
        self._due -= set(plan.order)
        return [Note(plan.as_record()), *told, Put(Turn(fence=self._put))]

    def _counters(self) -> Counters:
        """What the fleet has counted; its own count includes what it has proposed the view for."""
        own = self._reports[self._robot]
        newest = max(self._reports.values(), key=lambda report: report.counted.number)
        counters = own.counters if own.counted == newest.counted else newest.counters
        steps = max(report.counters.steps for report in self._reports.values())
        return changed(counters, steps=steps)

    def _newest_map(self) -> Report:
        return max(self._reports.values(), key=lambda report: (report.map_number, report.seen is not None))

    def _has_map(self, leader: int, now_s: float) -> bool:
        """Whether the newest map is here, or the leader has it, or it has not come for too long."""
        newest = self._newest_map()
        if newest.map_number <= self._reports[leader].map_number or newest.seen is not None:
            return True
        if self._asks_map_since_s is None:
            self._asks_map_since_s = now_s
            self._due |= self._reports.keys()
        return now_s - self._asks_map_since_s > self._timing.looks_s

    # --- answers ------------------------------------------------------------------------------------

    def _answers(self) -> Iterator[Command]:
        for robot in sorted(self._due):
            report = self._said[robot]
            if self.plan is not None and self.plan.lives.get(robot) == report.life:
                yield from (Say(robot, piece) for piece in self.plan.pieces(robot))
            else:
                yield Say(robot, self._answer(robot, report))
        self._due.clear()

    def _answer(self, robot: int, report: Report) -> Answer:
        draft = self._draft
        strand = draft.strand if draft is not None else []
        turn = self._turn_of.get(robot, 0)
        has_turn = self._put is not None and self._put.robot == robot and self._put.may is May.ONE
        return Answer(
            epoch=self._epoch,
            life=report.life,
            heard=report.number,
            after_turn=turn,
            out=self.plan is not None or robot not in self._reports,
            question=self._questions.pending(robot),
            join=self._join if has_turn else None,
            rank=strand.index(robot) if robot in strand else None,
            wants_map=self._asks_map_since_s is not None and self._newest_map() == report,
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
            self._draft.strand = [each for each in self._draft.strand if each != robot]
            if self.phase is not Phase.GATHERING:
                self._enter(Phase.GATHERING)
