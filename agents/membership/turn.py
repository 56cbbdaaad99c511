"""A robot's turn: the steps by which it joins the strand while every other robot stands.

Rule 1: it drives only under a fence that names it, and plans only from scans of that very fence.
Rule 2: it ends its turn standing, in place or blocked, and orders nothing more in that turn.
Rule 3: where obstacles move, a robot that gets no further looks again for a while before it is blocked, and
        looks while it drives. Robots that wait for a turn share this while, unless the robot is on its way:
        in a queue only the last one may have a way, and the turns of all others must not keep it waiting.
"""

from dataclasses import dataclass

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.body.watch import Watch
from agents.commands import Command, Note
from agents.liveness.timing import PATIENCE_S
from agents.membership.joining import InPlace, Joining
from agents.membership.stands import Stands
from agents.navigation.scan import View
from agents.navigation.step import LookCloser, NoStep
from protocol.arrays import places_xy, xy
from protocol.fence import Bearing
from protocol.mission import Mission
from protocol.timeline import RobotBlocked, RobotPlaced, StepPlanned
from protocol.wire.view import Join

LOOKS_AGAIN_S = 2.0  # who walks by has gone by then


@dataclass(frozen=True, slots=True)
class Ended:
    """How a turn has ended."""

    turn: int
    placed: bool


class TurnTaker:
    """What one robot does in its turn."""

    def __init__(
        self, mission: Mission, driver: Driver, senses: Senses, joining: Joining, join: Join, *, life: int
    ) -> None:
        """Begin the turn that odometry's fence gives to this life; `joining` outlives a turn."""
        fence = driver.odometry.fence
        driver.begin(0.0, Bearing(epoch=fence.epoch, turn=fence.turn, life=life))
        joining.begin(xy(driver.odometry.pose), epoch=fence.epoch.number, robots=join.robots)
        self._mission = mission
        self._driver = driver
        self._senses = senses
        self._watch = Watch(mission, driver, senses)
        self._joining = joining
        self._join = join
        self._stands = Stands(
            places_xy(join.strand), places_xy(join.waiting), places_xy(join.line), join.last_leg
        )
        self._step: StepPlanned | None = None
        self._stood_at: tuple[float, float] | None = None
        self._stood_at_s = self._looks_again_s = 0.0
        self.has_moved = False
        """Whether the robot may have left the place where it stood before the turn."""
        self.ended: Ended | None = None

    def act(self, now_s: float) -> list[Command]:
        """Look, plan and drive, until the turn has ended."""
        driver = self._driver
        commands = self._watch.look(now_s)
        if self._step is not None and self._watch.gives_up(now_s):
            self._watch.begin_again()
            self._step = None
            driver.stand()
        if not driver.standing:
            return commands
        step = self._step
        if step is not None and driver.progress_m < step.reach_m:
            driver.to(step.target, reach_m=step.reach_m)
            return commands
        self._step = None
        if now_s < self._looks_again_s:
            return commands
        scan = self._senses.take()
        if scan is None:
            return commands + self._senses.ask(now_s)
        return commands + self._plan(scan, now_s)

    def _plan(self, scan: View, now_s: float) -> list[Command]:
        planned = self._joining.plan(scan, self._stands)
        patient = self._mission.obstacles_move and not self._stays(scan, now_s)
        if isinstance(planned, StepPlanned) and self._mission.obstacles_move and not patient:
            planned = NoStep("its way stays blocked")
        here = {"x_m": float(scan.position[0]), "y_m": float(scan.position[1])}
        turn, rank = self._join.turn, len(self._join.strand)
        match planned:
            case InPlace():
                self.ended = Ended(turn, placed=True)
                return [Note(RobotPlaced(rank=rank, turn=turn, **here))]
            case LookCloser():
                self._senses.look_closer(scan)
                return self._senses.ask(now_s)
            case NoStep() if patient:
                self._looks_again_s = min(now_s + LOOKS_AGAIN_S, self._stood_at_s + self._patience_s)
                return []
            case NoStep(reason):
                self.ended = Ended(turn, placed=False)
                return [Note(RobotBlocked(turn=turn, reason=reason, **here))]
            case StepPlanned():
                self._step, self.has_moved = planned, True
                self._driver.to(planned.target, reach_m=planned.reach_m)
                return [Note(planned)]

    def _stays(self, scan: View, now_s: float) -> bool:
        """Rule 3: whether it has not got away from here for so long."""
        stands_at = (float(scan.position[0]), float(scan.position[1]))
        if stands_at != self._stood_at:
            self._stood_at, self._stood_at_s = stands_at, now_s
        return now_s - self._stood_at_s >= self._patience_s

    @property
    def _patience_s(self) -> float:
        """Rule 3."""
        return PATIENCE_S if self.has_moved else PATIENCE_S / (1 + len(self._join.waiting))
