"""One robot's part in the lining up: what it announces, when it may move, and when the strand has formed.

Rule 1: it announces itself on every change and on every heartbeat, until it has its place; so any
        announcement may be lost.
Rule 2: it senses where the order depends on it (without a goal), where it looks at its leg, and in its turn.
Rule 3: the last robot in place gives a turn to the nearest that is not, those apart that it gave one in vain;
        it gives the next when that one has said that its turn has ended. Where all have had theirs in vain
        it gives its own place up, once, and the turn back to the robot ahead, which tries others first; the
        leader gives itself a turn, once, to go where others can come.
Rule 4: a robot drives only in its turn, when all others have said that they know of it, and while each of
        them has echoed something that it said within `silence_s`. It ends its turn standing.
Rule 5: in an epoch that was called nobody drives before all members stand in it and whoever is left out must
        stand, too (docs/strand.md, Healing).
Rule 6: where obstacles move, a robot that gets no further looks again for a while before it is blocked.
"""

import math
from collections.abc import Set

import numpy as np
from msgspec.structs import replace

from agents.berth import Berth
from agents.commands import Announce, Command, Note
from agents.driver import Driver
from agents.joining import InPlace, Joining, Stands, leg_is_clear, without_hulls
from agents.muster import Legs, Roster, line_of
from agents.scan import View
from agents.step import NoStep
from agents.strand import URGENT_S
from protocol.arrays import Floats
from protocol.frames import Point, Pose
from protocol.messages import Muster, Turn
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M
from protocol.timeline import RobotBlocked, RobotPlaced, RouteLost, StepPlanned

PATIENCE_S = 10.0  # where obstacles move: as long as with a way in the strand that is blocked
MAKES_WAY_S = 5.0  # a process that is started again is there after two
COMES_BACK_S = 15.0
STALLS_S = 20.0  # the longest step, of 4 m, takes 8 s at 0.5 m/s, and twice that under heavy loss
LOOKS_AGAIN_S = 2.0  # who walks by has gone by then


class Lining:
    """What one robot knows and says while the strand forms."""

    def __init__(
        self,
        robot: int,
        mission: Mission,
        now_s: float = 0.0,
        *,
        epoch: int = 0,
        members: tuple[int, ...] = (),
        shunned: Set[int] = frozenset(),
        berth: Berth | None = None,
        attempt: int = 0,
    ) -> None:
        self.epoch = epoch
        """Of all that is said and ordered while the strand forms, whose own epoch is the next."""
        self.members = members or tuple(range(1, mission.robots + 1))
        self.free_at_s = None if members else now_s
        """Rule 5: when whoever has the turn, or leads, may drive; None until that is known."""
        self.began_s = now_s
        self._shunned = shunned
        self._robot = robot
        self._mission = mission
        least_m = 2.0 * mission.robot_radius_m + mission.separation_m - TOUCHING_M
        self._roster = Roster(self.members, mission.goal, least_m, attempt)
        self.attempt = attempt
        """How many orders of these members have been tried in vain."""
        self.wants_another_order = False
        self._heard_at_s: dict[int, float] = {}
        self._said = Muster(
            number=0,
            epoch=epoch,
            pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
            members=members,
            attempt=attempt,
        )
        self._berth = berth
        self._leg_is_driven = False
        self._announced = 0
        self._announced_at_s = -math.inf
        self._joining: Joining | None = None
        self._step: StepPlanned | None = None
        self._blocked: set[int] = set()
        self._lost = self._gave_up = self._got_clear = self._step_is_given_up = self._moved = False
        self.stuck_at_s: float | None = None
        """Since when nobody who remains finds a way to a place behind this robot, the last in place."""
        self._turn_state: tuple[Turn, int] | None = None
        self._turn_state_s = now_s
        self._stood_at: tuple[float, float, Turn] | None = None
        self._stood_at_s = 0.0
        self._looks_again_s = self._now_s = 0.0
        self.look: View | None = None
        """A scan from where the robot stands, without the hulls of others; None where it has taken none."""

    @property
    def is_called(self) -> bool:
        """Whether its members have been named: some robots may have been left out."""
        return bool(self._said.members)

    @property
    def all_are_bound(self) -> bool:
        """Whether all members stand in this epoch."""
        return self._roster.places is not None

    @property
    def places(self) -> dict[int, Pose]:
        """Where all robots stand."""
        places = self._roster.places
        assert places is not None, "nobody takes a place before all are known"
        return places

    @property
    def legs(self) -> Legs:
        """Corners of the ways to the robots ahead, by robot."""
        return self._roster.legs

    @property
    def berth(self) -> Berth | None:
        """Its place in the strand that it was in last, if it has not left it."""
        return None if self._moved else self._berth

    @property
    def leg_is_driven(self) -> bool:
        """Whether its leg is one that the robot ahead has driven, and both still stand at its ends."""
        rank = self.order.index(self._robot)
        both = [self._robot, self.order[rank - 1]]
        return self._leg_is_driven and not any(self._roster.heard[robot].ended for robot in both)

    @property
    def order(self) -> tuple[int, ...]:
        """The strand, leader first; empty until all are in place."""
        strand = self._roster.strand
        return strand if len(strand) == len(self.members) else ()

    @property
    def sensed(self) -> bool:
        """Whether a scan has been taken for the order."""
        return self._said.obstacle_m is not None

    @property
    def may_lead(self) -> bool:
        """Whether this robot leads and all have confirmed the strand."""
        return self.order[:1] == (self._robot,) and self._roster.agreed()

    def beside(self) -> list[Floats]:
        """Ground (n, 2) that each of the others may be on: where it stands."""
        if self._roster.places is None:
            return []
        return [np.repeat(place[None], 2, axis=0) for place in self._xy(self._others)]

    def give_up_step(self, driver: Driver) -> None:
        """Have the step in hand end where the robot comes to stand."""
        self._step_is_given_up = True
        driver.stand()

    def wants_scan(self, driver: Driver) -> bool:
        """Rule 2."""
        if self.look is None and (self._needs_obstacle or self._needs_leg):
            return True
        rested = self._now_s >= self._looks_again_s
        return self._may_drive and self._step is None and driver.standing and rested

    def hear(self, robot: int, muster: Muster, now_s: float) -> None:
        """Take in what another robot announces; in another lining up it is void."""
        if robot in self._shunned or muster.echo_s > now_s or muster.members != self._said.members:
            return
        if robot != self._robot and muster.epoch == self.epoch and self._roster.hear(robot, muster):
            self._heard_at_s[robot] = max(now_s, muster.t_s)

    def heard_at_s(self, robot: int) -> float:
        """When a member was heard last, or this lining up began."""
        return self._heard_at_s.get(robot, self.began_s)

    def stalled(self, now_s: float) -> int | None:
        """Who has the turn and has made nothing of it for long: it may not hear the others."""
        turn = self._roster.turn
        mover = self._roster.heard.get(turn.robot) if turn is not None else None
        state = None if turn is None or mover is None or mover.ended >= turn.number else (turn, mover.steps)
        if state != self._turn_state:
            self._turn_state, self._turn_state_s = state, now_s
        stalls = turn is not None and state is not None and now_s - self._turn_state_s > STALLS_S
        return turn.robot if turn is not None and stalls else None

    def unheard_pairs(self) -> set[tuple[int, int]]:
        """Which members have not heard which, as they say; who has said nothing has heard nobody."""
        heard = self._roster.heard
        return {
            (one, other)
            for one in self.members
            for other in self.members
            if one != other and (one not in heard or other not in heard[one].hears)
        }

    def act(self, driver: Driver, scan: View | None, now_s: float) -> list[Command]:
        """Sense, take a turn or give one, and announce what is new.

        Args:
            driver: the robot's own.
            scan: one that was taken where the robot stands, if there is a new one.
            now_s: the time.
        """
        self._now_s = now_s
        if self._announced == 0 and not driver.standing:
            return []
        pose = driver.odometry.pose
        if self._announced == 0 and self._berth is not None:
            self._say(pose=pose, former=self._berth.former(pose))  # at once: the order may depend on both
        if self._own_turn is None:
            self._say(pose=pose)
        if self._said.members:
            self._say(hears=tuple(sorted(self._roster.heard)))
        self._sense(scan)
        commands = self._take_turn(driver, scan) + self._give_turn()
        turn = self._roster.turn
        self._say(turn=turn.number if turn is not None else 0, order=self.order)
        return commands + self._announce(now_s)

    # --- rule 1 -------------------------------------------------------------------------------------

    def _say(self, **news: object) -> None:
        """Have the next announcement say so; a robot is the first to hear itself."""
        if any(getattr(self._said, name) != value for name, value in news.items()):
            self._said = replace(self._said, **{"number": self._said.number + 1, **news})
            self._roster.hear(self._robot, self._said)

    @property
    def _heartbeat_s(self) -> float:
        """While somebody has a turn, all that he waits for is said more often."""
        turn = self._roster.turn
        mover = self._roster.heard.get(turn.robot) if turn is not None else None
        waits = turn is not None and (mover is None or mover.ended < turn.number)
        return URGENT_S if waits else self._mission.heartbeat_s

    def _announce(self, now_s: float) -> list[Command]:
        if self._said.number == self._announced:
            if now_s - self._announced_at_s < self._heartbeat_s:
                return []
            self._say(number=self._said.number + 1)
        self._announced, self._announced_at_s = self._said.number, now_s
        turn = self._roster.turn
        mover = self._roster.heard.get(turn.robot) if turn is not None else None
        return [Announce(replace(self._said, t_s=now_s, echo_s=0.0 if mover is None else mover.t_s))]

    # --- rule 2 -------------------------------------------------------------------------------------

    @property
    def _needs_obstacle(self) -> bool:
        return self._mission.goal is None and self._roster.places is not None and not self.sensed

    @property
    def _needs_leg(self) -> bool:
        """Whether the order of the start is known, but not yet whether this robot's leg in it is clear."""
        order = self._roster.start_order
        looks = self._mission.law.promises_clearance and order[:1] != (self._robot,)
        return bool(order) and self._said.leg_clear is None and looks

    def _sense(self, scan: View | None) -> None:
        if scan is not None and (self._needs_obstacle or self._needs_leg):
            self.look = without_hulls(scan, self._xy(self._others), self._mission)
        if self._needs_obstacle and self.look is not None:
            nearest_m = self.look.nearest_m
            self._say(obstacle_m=self._mission.range_m_max if nearest_m is None else nearest_m)
        order = self._roster.start_order
        leg = self._former_leg(order) if self._needs_leg else None
        if leg is not None:
            self._leg_is_driven = True
            self._say(leg_clear=True, leg=leg)
        elif self._needs_leg and self.look is not None:
            ahead = self._xy([order[order.index(self._robot) - 1]])[0]
            self._say(leg_clear=leg_is_clear(self.look, ahead, self._mission))
        elif order and self._said.leg_clear is None and not self._needs_leg:
            self._say(leg_clear=True)

    def _former_leg(self, order: tuple[int, ...]) -> tuple[Point, ...] | None:
        """Corners of the way that the robot ahead has driven, where both still stand on it."""
        ahead = order[order.index(self._robot) - 1]
        own, theirs = self._said.former, self._roster.heard[ahead].former
        if self._berth is None or not self._roster.stays_behind(self._robot, ahead):
            return None
        assert own is not None, "asked just now"
        assert theirs is not None, "asked just now"
        return self._berth.leg(own.progress_m, theirs.progress_m)

    # --- rule 3 -------------------------------------------------------------------------------------

    def _give_turn(self) -> list[Command]:
        if self._own_turn is not None:
            return []
        strand, given, newest = self._roster.strand, self._said.gives, self._roster.turn
        if strand[-1:] != (self._robot,) or len(strand) == len(self.members) or self._lost:
            return []
        if newest is not None and newest.robot == self._robot and newest.number > self._said.ended:
            self._blocked = {self._roster.giver(newest)}  # it gave up its place for the others
        elif given is not None:
            theirs = self._roster.heard.get(given.robot)
            if theirs is None or theirs.ended < given.number:
                return []
            self._blocked.add(given.robot)
        number = 1 if newest is None else newest.number + 1
        waiting = [robot for robot in self._others if robot not in strand]
        free = [robot for robot in waiting if robot not in self._blocked]
        if not free:
            return self._give_up(strand, waiting, number)
        off_m = np.hypot(*(self._xy(free) - self._xy([self._robot])).T)
        self._say(gives=Turn(number=number, robot=free[int(np.argmin(off_m))]))
        return []

    def _give_up(self, strand: tuple[int, ...], waiting: list[int], number: int) -> list[Command]:
        """Nobody can come to a place behind this robot: it makes way, or nobody ever will.

        Who is left out may stand in the way, and come back: it is waited for before anybody leaves a place.
        """
        self.stuck_at_s = self._now_s if self.stuck_at_s is None else self.stuck_at_s
        if len(self.members) < self._mission.robots:
            patience_s = COMES_BACK_S if self._gave_up else MAKES_WAY_S
            if self._now_s - self.stuck_at_s < patience_s:
                return []
        if not self._gave_up:
            self._gave_up, self._blocked = True, set()
            if len(strand) > 1:
                self._say(gives=Turn(number=number, robot=strand[-2]), ended=number, rank=None)
            else:
                self._say(gives=Turn(number=number, robot=self._robot))
            return []
        if self.attempt < len(self.members):
            self.wants_another_order = True
            return []
        self._lost = True
        named = ", ".join(f"robot {robot}" for robot in waiting)
        return [Note(RouteLost(reason=f"no way to a place behind robot {self._robot} for {named}"))]

    # --- rule 4 -------------------------------------------------------------------------------------

    @property
    def _own_turn(self) -> Turn | None:
        """The turn that this robot has and has not ended."""
        turn = self._roster.turn
        if turn is None or turn.robot != self._robot:
            return None
        if self._robot in self._roster.strand and turn != self._said.gives:
            return None
        return turn if turn.number > self._said.ended else None

    @property
    def _may_drive(self) -> bool:
        turn, free_at_s = self._own_turn, self.free_at_s
        if turn is None or free_at_s is None or self._now_s < free_at_s:
            return False
        return self._roster.all_stand_in(turn, since_s=self._now_s - self._mission.silence_s)

    def _take_turn(self, driver: Driver, scan: View | None) -> list[Command]:
        if not self._may_drive:
            if self._step is not None:
                driver.stand()
            return []
        if not driver.standing:
            return []
        step = self._step
        if step is not None and driver.progress_m < step.reach_m and not self._step_is_given_up:
            driver.to(step.target, reach_m=step.reach_m, epoch=self.epoch)
            return []
        self._step, self._step_is_given_up = None, False
        return [] if scan is None else self._join(driver, scan)

    def _join(self, driver: Driver, scan: View) -> list[Command]:
        strand, turn, pose = self._roster.strand, self._own_turn, driver.odometry.pose
        assert turn is not None, "nobody joins out of turn"
        waiting = [robot for robot in self._others if robot not in strand]
        stands = self._stands(strand, waiting)
        self._joining = self._joining or Joining(self._mission, scan.position, epoch=self.epoch)
        if turn == self._said.gives:
            return self._get_clear(self._joining, driver, scan)
        planned = self._joining.plan(scan, stands)
        patient = self._mission.obstacles_move and not self._stays(pose, turn)
        if isinstance(planned, StepPlanned) and self._mission.obstacles_move and not patient:
            planned = NoStep("its way stays blocked")
        match planned:
            case InPlace():
                self.look = without_hulls(scan, stands.all, self._mission)
                self._blocked = set()
                self._say(pose=pose, ended=turn.number, rank=len(strand), gives=None)
                placed = RobotPlaced(rank=len(strand), turn=turn.number, x_m=pose.x_m, y_m=pose.y_m)
                return [Note(placed)]
            case NoStep() if patient:
                self._looks_again_s = self._now_s + LOOKS_AGAIN_S
                return []
            case NoStep(reason):
                self._say(pose=pose, ended=turn.number)
                return [Note(RobotBlocked(turn=turn.number, reason=reason, x_m=pose.x_m, y_m=pose.y_m))]
            case _:
                self._step, self._moved = planned, True
                self._say(steps=planned.step)
                driver.to(planned.target, reach_m=planned.reach_m, epoch=self.epoch)
                return [Note(planned)]

    def _get_clear(self, joining: Joining, driver: Driver, scan: View) -> list[Command]:
        """The leader goes one step, if there is one, and is in place at its end."""
        turn, pose = self._own_turn, driver.odometry.pose
        assert turn is not None, "nobody joins out of turn"
        planned = (
            NoStep("one step is enough") if self._got_clear else joining.clear(scan, self._xy(self._others))
        )
        if isinstance(planned, StepPlanned):
            self._got_clear, self._step, self._moved = True, planned, True
            driver.to(planned.target, reach_m=planned.reach_m, epoch=self.epoch)
            return [Note(planned)]
        self._say(pose=pose, ended=turn.number, rank=0)
        return [Note(RobotPlaced(rank=0, turn=turn.number, x_m=pose.x_m, y_m=pose.y_m))]

    def _stands(self, strand: tuple[int, ...], waiting: list[int]) -> Stands:
        line, leg = line_of(self.places, strand or (self._robot,), self._roster.legs)
        last_leg = int((leg == leg[-1]).sum()) if len(leg) else 0
        return Stands(self._xy(strand), self._xy(waiting), line, last_leg)

    def _stays(self, pose: Pose, turn: Turn) -> bool:
        """Rule 6: whether it has not got away from here for so long, in this turn."""
        stands_at = (pose.x_m, pose.y_m, turn)
        if stands_at != self._stood_at:
            self._stood_at, self._stood_at_s = stands_at, self._now_s
        return self._now_s - self._stood_at_s >= PATIENCE_S

    # --- small things -------------------------------------------------------------------------------

    @property
    def _others(self) -> list[int]:
        return [robot for robot in self.places if robot != self._robot]

    def _xy(self, robots: list[int] | tuple[int, ...]) -> Floats:
        """Where robots stand (n, 2) [m; world frame]."""
        places = self.places
        return np.array([(places[robot].x_m, places[robot].y_m) for robot in robots]).reshape(-1, 2)
