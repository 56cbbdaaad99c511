"""A leader's part in the strand: one switching step after the other, until the goal, or no way on.

Rule 1: it plans only where the path ends. If its body stands elsewhere, it wants a new formation.
Rule 2: where the only way leads back, it wants the strand to turn round. A tail that leads it out does not
        turn it round on a cleared map. It makes room before it takes a short step to the goal, since that
        step may end in a gap a little too narrow.
Rule 3: where it knows no way on, and the strand has lost robots, it wants another robot to lead. The route is
        lost if it is one of the last to lead and, where robots are left out, no body has moved for `GONE_S`
        while it waits. Where obstacles may move away, a leader waits first: before another leads, from when
        it first knew no way, whatever short steps and views have come since; else from its last step.
Rule 4: after each step that it gives up, but the first ones in an epoch, it waits before it plans again, for
        a time that its life draws. Else two leaders that see the same give way to each other for ever.
Rule 5 (safety): if it began too near to something, the robots behind do not come there. It wants a view when
        it has gone on. Where obstacles move, too: a permission to move keeps off contact alone. Nor does the
        strand turn round from there, since the leg that nobody has driven would count as driven: where the
        only way leads back, another robot leads.
"""

import math

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command, Note
from agents.liveness.reason import Reason, Turnabout
from agents.navigation.leg import place_is_clear
from agents.navigation.scan import View
from agents.navigation.step import Crossed, LookCloser, NoStep
from agents.navigation.sure import closer
from agents.strand.dead_end import cut_before_m
from agents.strand.leader import NO_WAY, DeadEnd, Leader, Plan, Wait
from agents.strand.memory import Memory
from agents.strand.strand import Strand
from protocol.arrays import Floats, xy
from protocol.fence import Cause
from protocol.mission import Mission
from protocol.path import THERE_M
from protocol.timeline import GoalReached, LawFailed, RobotArrived, RouteLost, StepAbandoned, StepPlanned

PATIENCE_S = 30.0  # with what stands in all ways on: who walks to and fro has come and gone by then
GONE_S = 15.0  # with robots that are left out: one that has gone for so long does not come back
STANDS_S = 2.0  # in the way for so long: no passer-by
GIVEN_UP_MAX = 2  # in one epoch without a wait: a passer-by costs a leader one or two steps
BACK_OFF_S = 2.0  # a robot drives by another in this time; the longest wait grows by it
BACK_OFFS_MAX = 4
SETTLED_S = 2.0  # who moves is heard of within a heartbeat a robot; between two of them another has begun


class Leading:
    """The state of a leader from step to step."""

    def __init__(
        self, mission: Mission, driver: Driver, senses: Senses, memory: Memory, strand: Strand
    ) -> None:
        self._mission = mission
        self._driver = driver
        self._senses = senses
        self._memory = memory
        self._strand = strand
        self._step: StepPlanned | None = None
        self._gives_up = self._lost = self._arrived = False
        self._given_up = 0  # steps, in this epoch
        self._plans_again_s = -math.inf
        self._waits = False  # for the strand to close up
        self._stuck_at_s = math.inf
        self._reason: Reason | None = None

    @property
    def reason(self) -> Reason | None:
        """Why it wants a new view; None: it wants none."""
        return self._reason

    @property
    def arrived(self) -> bool:
        """Whether it has come to the goal."""
        return self._arrived

    @property
    def knows_no_way(self) -> bool:
        """Whether it has found no step since its last one."""
        return self._stuck_at_s < math.inf

    @property
    def has_step(self) -> bool:
        """Whether a step is in hand."""
        return self._step is not None

    def act(self, now_s: float) -> list[Command]:
        """Drive the step in hand to its end, then plan the next one."""
        if self._lost or self._arrived or not self._driver.standing or self._drives_on():
            return []
        if self._gives_up and self._step is not None:
            self._plans_again_s = now_s + self._back_off_s()
        return self._end_step() + self.plan(now_s)

    def finish_step(self) -> list[Command]:
        """Drive the step in hand to its end, and plan no other."""
        return [] if not self._driver.standing or self._drives_on() else self._end_step()

    def give_up_step(self) -> None:
        """Stop, and end the step there."""
        self._gives_up = True
        self._driver.stand()

    def _back_off_s(self) -> float:
        """Rule 4: eight random bits of the life for each wait."""
        self._given_up += 1
        waits = self._given_up - GIVEN_UP_MAX
        share = (self._driver.bearing.life >> 8 * (waits % 8) & 0xFF) / 0xFF
        return share * BACK_OFF_S * min(max(waits, 0), BACK_OFFS_MAX)

    def _drives_on(self) -> bool:
        """Send the body on to the end of the step in hand, if it is not there."""
        step = self._step
        if step is None or self._gives_up or self._driver.progress_m >= step.reach_m:
            return False
        self._driver.to(step.target, reach_m=step.reach_m, step=step.step)
        return True

    def _end_step(self) -> list[Command]:
        """The step in hand has been driven, or is given up where the robot stands."""
        step, self._step = self._step, None
        gives_up, self._gives_up = self._gives_up, False
        if step is None:
            return []
        path, growth = self._strand.path, self._strand.growth
        growth.come_to(self._driver.progress_m)
        growth.end()
        if not gives_up:
            return []
        end = path.at(path.end_m)
        self._driver.end_at(path.end_m)
        return [Note(StepAbandoned(step=step.step, epoch=step.epoch, x_m=end.x_m, y_m=end.y_m))]

    # --- planning -----------------------------------------------------------------------------------

    def plan(self, now_s: float, *, room_m: float | None = None) -> list[Command]:
        """Plan the next step from a scan.

        Args:
            now_s: the time.
            room_m: where the tail wants to come back, how far it has still to go: if there is no step
                towards the goal, one that makes so much room.
        """
        strand, leader = self._strand, self._memory.leader(self._driver.odometry.pose)
        if strand.grants.withheld and not self._begins:
            self._reason = Reason(Cause.MISFIT, "it began too near to something for others to come there")
            return []
        if leader.is_done(self._position()):
            return self._reach_goal()
        if self._lost or self._is_pausing(now_s):
            return []
        if self._off_path_m > self._mission.mu0_m and self._mission.promises_clearance:
            why = f"robot {strand.robot} stands {self._off_path_m:.3f} m off the path's end"
            self._reason = Reason(Cause.MISFIT, why, about=strand.robot)
            return []
        scan = self._senses.take()
        if scan is None:
            return self._senses.ask(now_s)
        planned = self._planned(leader, scan, now_s, room_m)
        behind = strand.behind
        self._memory.hand_on(0 if behind is None or behind.state is None else behind.state.handed)
        if isinstance(planned, LookCloser):
            self._senses.look_closer(scan)
        failure = leader.take_failure()
        failed = [] if failure is None else [Note(LawFailed(reason=failure))]
        return [*failed, *self._carry_out(planned, now_s)]

    def _is_pausing(self, now_s: float) -> bool:
        """Whether it is too early to plan again: a strand that has closed up is no longer waited for."""
        return now_s < self._plans_again_s and not (self._waits and self._strand.quiet_s >= SETTLED_S)

    def _planned(self, leader: Leader, scan: View, now_s: float, room_m: float | None) -> Plan:
        strand = self._strand
        ground = strand.grants.ground
        if strand.behind is not None and self._begins:
            too_near = self._is_too_near(scan)
            strand.grants.withhold(too_near=too_near)
            if too_near and closer(self._mission, len(scan.ranges_m)) is not None:
                return LookCloser()
        planned = leader.plan(
            scan,
            ground,
            epoch=strand.number,
            settled=strand.quiet_s >= SETTLED_S,
            bodies_may_move=self._has_lost_some,
            may_forget=room_m is not None or not strand.tries_leaders,
            tail_may_lead=strand.counters.in_vain == 0,
            all_stand=now_s - self._stuck_at_s >= STANDS_S,
        )
        if room_m is not None and isinstance(planned, DeadEnd) and leader.has_forgotten:
            planned = NO_WAY  # a new map does not show what the other end has seen
        if room_m is None or planned == NO_WAY:
            return planned
        far_m = planned.length_m if isinstance(planned, StepPlanned) else 0.0
        if far_m < min(room_m, self._mission.robot_keep_m):
            away = leader.make_room(scan, ground, epoch=strand.number, room_m=room_m)
            if isinstance(away, StepPlanned) or not isinstance(planned, StepPlanned):
                return away
        strand.lead_on()
        return planned

    @property
    def _begins(self) -> bool:
        """Whether it stands at its place in the formation."""
        return self._driver.progress_m <= self._strand.start_m + THERE_M

    def _is_too_near(self, scan: View) -> bool:
        """Rule 5: whether something is too near for another robot to come to where this one stands."""
        mission = self._mission
        if not mission.promises_clearance:
            return False
        ground = self._strand.grants.ground.occupied
        return not place_is_clear(scan.without_on([ground], within_m=mission.hull_reach_m), mission)

    @property
    def _off_path_m(self) -> float:
        path = self._strand.path
        return math.dist(self._position(), xy(path.at(path.end_m)))

    def _carry_out(self, planned: Plan, now_s: float) -> list[Command]:
        self._reason, self._waits = None, isinstance(planned, Wait)
        if isinstance(planned, NoStep | DeadEnd):
            self._memory.note_no_way(self._position(), now_s, anew=not self._may_hand_on)
        match planned:
            case StepPlanned():
                return self._begin(planned)
            case Crossed():
                return self._reach_goal()
            case LookCloser():
                return self._senses.ask(now_s)
            case NoStep(reason) if self._is_lost(now_s):
                self._plans_again_s = now_s + SETTLED_S
                return self._give_up_lead(reason, now_s)
            case DeadEnd(back_to_m):
                self._plans_again_s = now_s + SETTLED_S
                self._turn_back(back_to_m)
            case NoStep() | Wait():
                pass
        self._plans_again_s = now_s + SETTLED_S
        return []

    def _turn_back(self, back_to_m: float | None) -> None:
        """Rule 2; by rule 5 another robot leads instead."""
        strand, tail_m = self._strand, self._strand.grants.tail_m
        if strand.grants.withheld:
            self._reason = Reason(Cause.NO_WAY, "the only way leads back, and it began too near to something")
            return
        back_by_m, cut_m = 0.0, tail_m
        if back_to_m is not None:
            path, robots = strand.path, strand.members
            back_by_m = max(0.0, path.end_m - back_to_m)
            cut_m = cut_before_m(path, self._mission, robots=robots, tail_m=tail_m, back_by_m=back_by_m)
        turnabout = Turnabout(cut_m=cut_m, end_m=self._driver.progress_m, back_by_m=back_by_m)
        self._reason = Reason(Cause.DEAD_END, "the only way leads back", turnabout=turnabout)

    def _begin(self, planned: StepPlanned) -> list[Command]:
        self._stuck_at_s = math.inf
        self._step = planned
        self._strand.growth.begin(planned.target, self._memory.onward)
        self._drives_on()
        return [Note(planned)]

    def _is_lost(self, now_s: float) -> bool:
        """Whether a way that is not there will not be: what moves into the way may move on."""
        self._stuck_at_s = min(self._stuck_at_s, now_s)
        since_s = self._memory.no_way_since_s if self._may_hand_on else self._stuck_at_s
        return now_s - since_s >= (PATIENCE_S if self._mission.obstacles_move else 0.0)

    def _give_up_lead(self, reason: str, now_s: float) -> list[Command]:
        """Rule 3."""
        if not self._may_hand_on:
            # In an outage or a stop all bodies stand, and nobody can come back.
            waited_s = min(self._driver.odometry.stood_s, now_s - self._stuck_at_s)
            may_come_back = self._some_are_left_out and waited_s < GONE_S
            return [] if may_come_back else self.lose(reason)
        self._reason = Reason(Cause.NO_WAY, reason)
        return []

    @property
    def _may_hand_on(self) -> bool:
        """Whether another robot may lead."""
        return self._has_lost_some and self._strand.robot not in self._strand.counters.last_to_lead

    def lose(self, reason: str) -> list[Command]:
        """Record once that the route is lost."""
        is_lost, self._lost = self._lost, True
        return [] if is_lost else [Note(RouteLost(reason=reason))]

    @property
    def _some_are_left_out(self) -> bool:
        return self._strand.members < self._mission.robots

    @property
    def _has_lost_some(self) -> bool:
        """Whether the fleet has left robots out, now or in a former strand: maps may show their bodies."""
        return self._some_are_left_out or self._strand.counters.heals > 0

    def _reach_goal(self) -> list[Command]:
        self._strand.lead_on()
        reached = Note(GoalReached(**self._here()))
        if self._arrived:
            return [reached]
        self._arrived = True
        self._strand.grants.withhold(too_near=False)  # of `Grants`, rule 4
        return [reached, Note(RobotArrived(progress_m=self._driver.progress_m))]

    def _position(self) -> Floats:
        return xy(self._driver.odometry.pose)

    def _here(self) -> dict[str, float]:
        pose = self._driver.odometry.pose
        return {"x_m": pose.x_m, "y_m": pose.y_m}
