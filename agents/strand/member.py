"""A robot's part in the strand: it leads, backs up or follows, by its rank, until it has arrived.

Rule 1: a robot stands while a link is silent, before whoever was left out must stand, while it waits for
        the one behind it, and from when it has passed on that the strand turns round until it has.
Rule 2: the first robot of the strand leads. Where its tail wants to come back, the first backs up along the
        path that there is until the tail has. Where there is no more path it leads for good, if it knows
        a way; else it makes room.
Rule 3: where obstacles move, a robot looks while it drives (`agents.body.watch`).
Rule 4: ground that a robot has driven or checked itself stays clear for it, whichever way it goes.
Rule 5: a robot whose way has been blocked for too long says so, and so does each robot ahead of it; a first
        that backs up may be kept back by robots behind. The first then stops where it is and has the strand
        dissolve, so often at the most; the others stop when they hear of it.
"""

import numpy as np
from protocol.epochs import is_called

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.body.watch import STILL_S_MAX, Watch
from agents.commands import Command, Note
from agents.events import LinkHeard
from agents.navigation.scan import View
from agents.navigation.step import Crossed, NoStep
from agents.strand.advance import Advance
from agents.strand.follower import Follower
from agents.strand.forming import as_record
from agents.strand.leader import DeadEnd, LookCloser, Plan, Wait
from agents.strand.memory import Memory
from agents.strand.strand import COMES_BACK_S, Own, Strand
from protocol.arrays import Floats
from protocol.mission import Mission
from protocol.path import THERE_M
from protocol.timeline import (
    GoalReached,
    RobotArrived,
    RobotHeld,
    RobotReleased,
    RouteLost,
    StepAbandoned,
    StepPlanned,
    StrandDissolved,
    StrandHealed,
    StrandReversed,
)
from protocol.wire.messages import AheadState, Dissolution, Reversal

RELEASE_SHARE = 0.9  # of the link's length: so that a robot at the limit does not stop and go
PATIENCE_S = 30.0  # with what stands in all ways on: who walks to and fro has come and gone by then
TURNS_MAX = 8  # with no step towards the goal between them
BLOCKED_S = 5.0  # five checks; on ground where nothing moves only a robot out of its place goes away
DISSOLVED_MAX = 8  # in all: every time may undo what the time before has done
GROWN_M_MIN = 0.1  # of the path, worth telling
SETTLED_S = 2.0  # who moves is heard of within a heartbeat a robot; between two of them another has begun


class Member:
    """The decisions of one robot in the strand."""

    def __init__(
        self,
        mission: Mission,
        driver: Driver,
        senses: Senses,
        strand: Strand,
        memory: Memory,
        *,
        free_at_s: float = 0.0,
        other_orders: bool = False,
    ) -> None:
        """Take a place in a strand.

        Args:
            mission: what all robots are told.
            driver: the robot's own.
            senses: likewise.
            strand: where its place is.
            memory: what outlives a strand.
            free_at_s: when whoever was left out must stand.
            other_orders: whether there are some to try where this one's leader knows no way on.
        """
        self._mission = mission
        self._driver = driver
        self._senses = senses
        senses.trust_from(free_at_s)
        self._watch = Watch(mission, driver, senses)
        self._memory = memory
        self.strand = strand
        self.follower = Follower(mission, strand.start_m, some_are_left_out=self._some_are_left_out)
        self._advance = Advance(mission, driver, senses, self.follower)
        self._step: StepPlanned | None = None
        self._revolutions = mission.revolutions
        self._turns = 0
        self._out_at_m = 0.0
        self._gives_up = False
        self._plans_again_s = 0.0
        self._stuck_at_s = np.inf
        self._held = self._lost = False
        self.arrived = False
        """Whether it has come to its place at the goal, behind the robots ahead."""
        self._free_at_s = free_at_s
        self._other_orders = other_orders
        self.wants_another_order = False
        """Whether it leads and knows no way on, and another robot might."""
        self._heals = is_called(strand.epoch)
        self._moved_before = False

    @property
    def _some_are_left_out(self) -> bool:
        return len(self.strand.order) < self._mission.robots

    @property
    def has_moved(self) -> bool:
        """Whether it may have left the place where the strand formed, also before it turned round."""
        return self._moved_before or self._driver.was_sent

    def hear(self, heard: LinkHeard, now_s: float) -> list[Command]:
        """Take in a neighbour's state; the first of the next epoch turns this robot round."""
        strand, state = self.strand, heard.state
        from_behind = strand.behind is not None and heard.robot == strand.behind.neighbour
        if (
            from_behind
            and strand.reversal
            and isinstance(state, AheadState)
            and state.epoch == strand.epoch + 1
        ):
            return self._turn_round(now_s, state) + self.strand.hear(heard, now_s)
        commands = strand.hear(heard, now_s)
        if strand.handed is not None:
            self._memory.succeed(strand.handed)
        return commands

    def take_look(self, look: View, now_s: float) -> Command:
        """Take a scan in that was taken right here, and showed the leg clear: it need not be taken again."""
        strand = self.strand
        checked = self.follower.check(
            look,
            strand.path,
            progress_m=strand.start_m,
            authority_m=strand.start_m,
            own_leg_m=strand.own_leg_m,
            ahead_start_m=strand.ahead_start_m,
            now_s=now_s,
        )
        return Note(checked)

    def act(self, now_s: float) -> list[Command]:
        """What is to be done now."""
        blocked = self._blocked(now_s)
        commands = self._hold() + self._dissolve(blocked)
        if not self.strand.halted and self._driver.standing:
            self.strand.pass_on_reversal()
        if self.strand.reversal is not None and self.strand.behind is None:
            commands += self._turn_round(now_s, None)
        commands += self._move(now_s)
        commands += self._look(now_s)
        driver, handover = self._driver, self._memory.handover
        pose, standing = driver.odometry.pose, driver.standing
        own = Own(driver.progress_m, pose, standing, self.arrived, handover, blocked)
        return commands + self.strand.tell(own, now_s)

    def _move(self, now_s: float) -> list[Command]:
        strand = self.strand
        if strand.halted:
            return []
        if strand.silent or self._held or now_s < self._free_at_s:
            self._driver.stand()
            follows = strand.ahead is not None and now_s >= self._free_at_s
            return self._advance.look_ahead(strand, now_s) if follows else []
        if self._heals:
            self._heals = False
            if strand.ahead is None:
                healed = StrandHealed(epoch=strand.epoch, members=tuple(sorted(strand.order)))
                return [Note(healed), *self._lead(now_s)]
        if strand.ahead is not None:
            return self._follow(now_s)
        return self._back_up(now_s) if strand.back_by_m > 0.0 else self._lead(now_s)

    def _look(self, now_s: float) -> list[Command]:
        """Rule 3: drive on as long as the newest scan is good; give up a step that stays without one."""
        driver = self._driver
        if driver.progress_m - self.strand.path.end_m >= GROWN_M_MIN:
            self.strand.growth.come_to(driver.progress_m)
        looks = self._watch.look(self.strand.robots_beside, now_s)
        if self._step is not None and self._watch.gives_up(now_s):
            self._gives_up = True
            driver.stand()
            return []
        return looks

    def _hold(self) -> list[Command]:
        """The stretch rule: wait for a follower that is too far behind what it has been granted."""
        if self.strand.back_by_m > 0.0:
            return []  # whoever makes way does not wait for those that will not come further
        limit_m = self._mission.link_length_m_max * (RELEASE_SHARE if self._held else 1.0)
        if (self.strand.grants.stretch_m > limit_m) == self._held:
            return []
        self._held = not self._held
        return [Note(RobotHeld(behind_m=self.strand.grants.stretch_m) if self._held else RobotReleased())]

    # --- dissolving ---------------------------------------------------------------------------------

    def _blocked(self, now_s: float) -> int | None:
        """Rule 5: which robot's way is blocked, its own or that of one behind it."""
        stopped_at_s = min(self.follower.refused_at_s, self._watch.still_since_s)
        patience_s = STILL_S_MAX if self._mission.obstacles_move else BLOCKED_S
        if self.strand.ahead is None and self.strand.quiet_s(now_s) >= patience_s:
            stopped_at_s = min(stopped_at_s, self._advance.kept_back_at_s)
        if not self._held and now_s - stopped_at_s >= patience_s:
            return self.strand.robot
        return self.strand.blocked_behind

    def _dissolve(self, blocked: int | None) -> list[Command]:
        """Rule 5: stop, and when this robot stands, have the strand dissolve or pass on that it does."""
        strand = self.strand
        leads = strand.ahead is None
        if strand.halted or self._lost or (blocked is None if leads else strand.dissolves_ahead is None):
            return []
        self._driver.stand()
        if not self._driver.standing:
            return []
        if not leads:
            strand.dissolution = strand.dissolves_ahead
            return []
        assert blocked is not None, "asked above"
        if self._memory.dissolved >= DISSOLVED_MAX:
            self._lost = True
            reason = f"the way of robot {blocked} is blocked, and the strand has dissolved too often in vain"
            return [Note(RouteLost(reason=reason))]
        strand.dissolution = Dissolution(times=self._memory.dissolved + 1, seen=self._memory.seen)
        return [Note(StrandDissolved(epoch=strand.epoch, blocked=blocked))]

    @property
    def leaves_dead_end(self) -> bool:
        """Whether it leads a strand that has turned round, whose tail is still where the others were."""
        return self.strand.grants.tail_m < self._out_at_m and self._stuck_at_s == np.inf

    @property
    def dissolves(self) -> bool:
        """Whether this robot only waits for the next lining up."""
        return self.strand.dissolution is not None

    # --- turning round ------------------------------------------------------------------------------

    def _reverse(self, *, cut_m: float, back_by_m: float) -> list[Command]:
        """Have the strand turn round; this robot leads it, and stands."""
        strand, end_m = self.strand, self._driver.progress_m
        self._turns += 1
        seen = self._memory.seen
        strand.reverse(Reversal(cut_m=cut_m, end_m=end_m, back_by_m=back_by_m, turns=self._turns, seen=seen))
        return [Note(StrandReversed(epoch=strand.epoch, cut_m=cut_m, end_m=end_m, back_by_m=back_by_m))]

    def _turn_round(self, now_s: float, first: AheadState | None) -> list[Command]:
        """Take the place in the next epoch's strand."""
        old, driver = self.strand, self._driver
        self._moved_before = self.has_moved
        assert old.reversal is not None, "a strand turns round when all have been told"
        self.strand = old.turned_round(driver.progress_m, now_s, first)
        self.follower.turn_round(
            cut_m=old.reversal.cut_m, end_m=old.reversal.end_m, progress_m=driver.progress_m
        )
        self._memory.take(old.reversal.seen)
        self._held, self._turns = False, old.reversal.turns
        self._out_at_m = self.strand.laid_m
        driver.begin(self.strand.start_m)
        return [Note(as_record(self.strand, sensed=False, bent=False))]

    def _back_up(self, now_s: float) -> list[Command]:
        """Rule 2: drive along the path that there is, so that the robots behind can."""
        strand, driver = self.strand, self._driver
        if strand.grants.tail_m >= strand.back_by_m - THERE_M:
            driver.stand()
            return self._reverse(cut_m=strand.back_by_m, back_by_m=0.0) if driver.standing else []
        step = self._step
        if step is not None and step.epoch == strand.epoch:  # it makes room
            under_way = not driver.standing or driver.progress_m < step.reach_m
            return self._lead(now_s) if under_way else self._end_step()
        if driver.standing and driver.progress_m >= strand.path.end_m - THERE_M:
            # Those behind may still be on their way back.
            return [] if strand.quiet_s(now_s) < SETTLED_S else self._plan(now_s)
        return self._advance.along(strand, strand.path.end_m, now_s, final=True)[0]

    # --- leading ------------------------------------------------------------------------------------

    def _lead(self, now_s: float) -> list[Command]:
        if self.arrived or self._lost or not self._driver.standing:
            return []
        step, strand = self._step, self.strand
        under_way = step is not None and step.epoch == strand.epoch and not self._gives_up
        if step is not None and under_way and self._driver.progress_m < step.reach_m:
            self._driver.to(step.target, reach_m=step.reach_m, epoch=strand.epoch, step=step.step)
            return []
        return self._end_step() + self._plan(now_s)

    def _end_step(self) -> list[Command]:
        """The step in hand has been driven, or is given up where the robot stands."""
        step, self._step = self._step, None
        gives_up, self._gives_up = self._gives_up, False
        if step is None or step.epoch != self.strand.epoch:
            return []
        path = self.strand.path
        self.strand.growth.come_to(self._driver.progress_m)
        self.strand.growth.end()
        if not gives_up:
            return []
        end = path.at(path.end_m)
        self._driver.progress_m = path.end_m
        return [Note(StepAbandoned(step=step.step, epoch=step.epoch, x_m=end.x_m, y_m=end.y_m))]

    def _plan(self, now_s: float) -> list[Command]:
        leader, strand = self._memory.leader(self._driver.odometry.pose), self.strand
        leader.bodies_may_move |= self._some_are_left_out
        settled = strand.quiet_s(now_s) >= SETTLED_S
        if leader.is_done(self._position()):
            strand.back_by_m = 0.0
            return [Note(GoalReached(**self._here())), *self._arrive()]
        if self._lost or self.wants_another_order or now_s < self._plans_again_s:
            return []
        scan = self._senses.take(revolutions=self._revolutions)
        if scan is None:
            return self._senses.ask(now_s, revolutions=self._revolutions)
        planned = leader.plan(scan, strand.grants.ground, epoch=strand.epoch, settled=settled)
        if strand.back_by_m > 0.0 and isinstance(planned, StepPlanned):
            strand.back_by_m = 0.0  # rule 2: from here it leads for good
        elif strand.back_by_m > 0.0:
            room_m = strand.back_by_m - strand.grants.tail_m
            planned = leader.make_room(scan, strand.grants.ground, epoch=strand.epoch, room_m=room_m)
        if strand.behind is not None and strand.behind.state is not None:
            self._memory.hand_on(strand.behind.state.handed)
        self._revolutions = leader.closer if isinstance(planned, LookCloser) else self._mission.revolutions
        return self._carry_out(planned, now_s)

    def _carry_out(self, planned: Plan, now_s: float) -> list[Command]:
        commands: list[Command] = []
        match planned:
            case NoStep() if self._other_orders and self._is_lost(now_s):
                self.wants_another_order = True
            case NoStep(reason) if self._is_lost(now_s):
                self._lost = True
                commands = [Note(RouteLost(reason=reason))]
            case NoStep() | Wait():
                self._plans_again_s = now_s + SETTLED_S
            case Crossed():
                commands = [Note(GoalReached(**self._here())), *self._arrive()]
            case DeadEnd() if self._turns >= TURNS_MAX:
                self._lost = True
                commands = [Note(RouteLost(reason="the strand has turned round too often in vain"))]
            case DeadEnd(back_to_m):
                commands = self._reverse(cut_m=0.0, back_by_m=self.strand.path.end_m - back_to_m)
            case LookCloser():
                commands = self._senses.ask(now_s, revolutions=self._revolutions)
            case StepPlanned():
                self._stuck_at_s = np.inf
                self._turns = self._turns if self.strand.back_by_m > 0.0 else 0
                commands = self._begin(planned)
        return commands

    def _is_lost(self, now_s: float) -> bool:
        """Whether a way that is not there will not be: what moves into the way may move on."""
        self._stuck_at_s = min(self._stuck_at_s, now_s)
        patience_s = PATIENCE_S if self._mission.obstacles_move else 0.0
        if self._some_are_left_out:
            patience_s = max(patience_s, COMES_BACK_S)
        return now_s - self._stuck_at_s >= patience_s

    def _begin(self, planned: StepPlanned) -> list[Command]:
        self._step = planned
        self.strand.growth.begin(planned.target)
        self._driver.to(planned.target, reach_m=planned.reach_m, epoch=self.strand.epoch, step=planned.step)
        return [Note(planned)]

    # --- following ----------------------------------------------------------------------------------

    def _follow(self, now_s: float) -> list[Command]:
        strand = self.strand
        assert strand.ahead is not None
        assert strand.ahead.state is not None, "a link that has not been heard is silent"
        final, authority_m = strand.ahead.state.arrived, strand.authority_m
        if not strand.ahead.state.backs_up:
            strand.back_by_m = 0.0
        elif strand.behind is None:
            authority_m, final = min(authority_m, strand.back_by_m), authority_m >= strand.back_by_m
        commands, there = self._advance.along(strand, authority_m, now_s, final=final)
        return self._arrive() if there and strand.ahead.state.arrived else commands

    def _arrive(self) -> list[Command]:
        if self.arrived:
            return []
        self.arrived = True
        return [Note(RobotArrived(progress_m=self._driver.progress_m))]

    def _position(self) -> Floats:
        pose = self._driver.odometry.pose
        return np.array([pose.x_m, pose.y_m])

    def _here(self) -> dict[str, float]:
        pose = self._driver.odometry.pose
        return {"x_m": pose.x_m, "y_m": pose.y_m}
