"""A robot's turn in a lining up: the steps by which it joins the strand.

Rule 1: it drives only while it may (`agents.membership.lining`), and ends its turn standing: in place, or
        blocked.
Rule 2: where obstacles move, a robot that gets no further looks again for a while before it is blocked.
Rule 3: a turn has so many steps at the most: what is seen from one place may undo what is seen from another.
Rule 4: the leader that has given itself a turn goes one step, where others can come.
"""

from collections import Counter

from agents.body.driver import Driver
from agents.commands import Command, Note
from agents.membership.announcer import Announcer
from agents.membership.giving import Giving
from agents.membership.joining import InPlace, Joining, Stands, without_hulls
from agents.membership.muster import line_of
from agents.navigation.scan import View
from agents.navigation.step import NoStep
from protocol.frames import Pose
from protocol.mission import Mission
from protocol.timeline import RobotBlocked, RobotPlaced, StepPlanned
from protocol.wire.messages import Turn

TURN_STEPS_MAX = 64  # the longest crossing of a real scene took 41
PATIENCE_S = 10.0  # where obstacles move: as long as with a way in the strand that is blocked
LOOKS_AGAIN_S = 2.0  # who walks by has gone by then


class Taking:
    """What one robot does in its turns."""

    def __init__(self, announcer: Announcer, giving: Giving, mission: Mission, epoch: int) -> None:
        self._announcer = announcer
        self._giving = giving
        self._mission = mission
        self._epoch = epoch
        self._joining: Joining | None = None
        self._step: StepPlanned | None = None
        self._steps: Counter[int] = Counter()
        """By turn."""
        self._got_clear = self._step_is_given_up = False
        self.has_moved = False
        self._stood_at: tuple[float, float, Turn] | None = None
        self._stood_at_s = 0.0
        self._looks_again_s = 0.0

    def wants_scan(self, driver: Driver, now_s: float) -> bool:
        """Whether it has to look before it plans; to be asked in its turn."""
        return self._step is None and driver.standing and now_s >= self._looks_again_s

    def give_up_step(self, driver: Driver) -> None:
        """Have the step in hand end where the robot comes to stand."""
        self._step_is_given_up = True
        driver.stand()

    def take(self, driver: Driver, scan: View | None, now_s: float, *, may_drive: bool) -> list[Command]:
        """Drive in the turn that this robot has, or end it."""
        if self._step is not None:
            self._announcer.say(made_m=round(driver.progress_m, 1))
        if not may_drive:
            if self._step is not None:
                driver.stand()
            return []
        if not driver.standing:
            return []
        step = self._step
        if step is not None and driver.progress_m < step.reach_m and not self._step_is_given_up:
            driver.to(step.target, reach_m=step.reach_m, epoch=self._epoch)
            return []
        self._step, self._step_is_given_up = None, False
        return [] if scan is None else self._join(driver, scan, now_s)

    def _join(self, driver: Driver, scan: View, now_s: float) -> list[Command]:
        announcer, pose = self._announcer, driver.odometry.pose
        strand, turn = announcer.roster.strand, announcer.own_turn
        assert turn is not None, "nobody joins out of turn"
        waiting = [robot for robot in announcer.others if robot not in strand]
        stands = self._stands(strand, waiting)
        self._joining = self._joining or Joining(self._mission, scan.position, epoch=self._epoch)
        if turn == announcer.said.gives:
            return self._get_clear(self._joining, driver, scan)
        planned = self._joining.plan(scan, stands)
        patient = self._mission.obstacles_move and not self._stays(pose, turn, now_s)
        if isinstance(planned, StepPlanned) and self._mission.obstacles_move and not patient:
            planned = NoStep("its way stays blocked")
        if isinstance(planned, StepPlanned) and self._steps[turn.number] >= TURN_STEPS_MAX:
            planned = NoStep(f"{TURN_STEPS_MAX} steps have not led to the strand's end")
        match planned:
            case InPlace():
                announcer.look = without_hulls(scan, stands.all, self._mission)
                self._giving.begin()
                announcer.say(pose=pose, ended=turn.number, rank=len(strand), gives=None)
                placed = RobotPlaced(rank=len(strand), turn=turn.number, x_m=pose.x_m, y_m=pose.y_m)
                return [Note(placed)]
            case NoStep() if patient:
                self._looks_again_s = now_s + LOOKS_AGAIN_S
                return []
            case NoStep(reason):
                announcer.say(pose=pose, ended=turn.number)
                return [Note(RobotBlocked(turn=turn.number, reason=reason, x_m=pose.x_m, y_m=pose.y_m))]
            case _:
                self._steps[turn.number] += 1
                self._step, self.has_moved = planned, True
                driver.to(planned.target, reach_m=planned.reach_m, epoch=self._epoch)
                return [Note(planned)]

    def _get_clear(self, joining: Joining, driver: Driver, scan: View) -> list[Command]:
        """The leader goes one step, if there is one, and is in place at its end."""
        announcer, pose = self._announcer, driver.odometry.pose
        turn = announcer.own_turn
        assert turn is not None, "nobody joins out of turn"
        planned = (
            NoStep("one step is enough")
            if self._got_clear
            else joining.clear(scan, announcer.xy_of(announcer.others))
        )
        if isinstance(planned, StepPlanned):
            self._got_clear, self._step, self.has_moved = True, planned, True
            driver.to(planned.target, reach_m=planned.reach_m, epoch=self._epoch)
            return [Note(planned)]
        announcer.say(pose=pose, ended=turn.number, rank=0)
        return [Note(RobotPlaced(rank=0, turn=turn.number, x_m=pose.x_m, y_m=pose.y_m))]

    def _stands(self, strand: tuple[int, ...], waiting: list[int]) -> Stands:
        announcer = self._announcer
        line, leg = line_of(announcer.places, strand or (announcer.robot,), announcer.roster.legs)
        last_leg = int((leg == leg[-1]).sum()) if len(leg) else 0
        return Stands(announcer.xy_of(strand), announcer.xy_of(waiting), line, last_leg)

    def _stays(self, pose: Pose, turn: Turn, now_s: float) -> bool:
        """Rule 2: whether it has not got away from here for so long, in this turn."""
        stands_at = (pose.x_m, pose.y_m, turn)
        if stands_at != self._stood_at:
            self._stood_at, self._stood_at_s = stands_at, now_s
        return now_s - self._stood_at_s >= PATIENCE_S
