"""Coverage counters for views, turn leases and formations, counted from a timeline. Pure.

Rule 1: the fence alone says which epoch is in force, who coordinates it, who has the turn and who may drive.
Rule 2: a view forms from its first fence until its ALL.
Rule 3: a formation reached a member late or never if the member lived and did not take its place within
        `ACTS_S` of ALL, or at all.
Rule 4: a succession lasts from the view after a loss until `SUCCEEDS_S` after its ALL: its coordinator, and
        then the new leader, can be killed in it.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field

from clew.coverage.situations import OF_CAUSE, Situation
from protocol.fence import NUMBERS, Cause, May
from protocol.keys import WORLD, robot_number
from protocol.timeline import (
    FaultInjected,
    FenceChanged,
    Record,
    RobotBlocked,
    RobotPlaced,
    RobotStranded,
    StrandDissolved,
    StrandFormed,
    StrandJoined,
    StrandReversed,
    ViewLeft,
    ViewProposed,
)

ACTS_S = 0.5  # a member acts on its formation at the first odometry after ALL, which comes within 0.1 s
SUCCEEDS_S = 2.0  # until the first step of the new leader, mostly
FIRST = FenceChanged(epoch=0, turn=0, may=May.NOBODY, coordinator=0, life="")
"""The fence with which a run begins."""
LOSSES = frozenset({Cause.NEIGHBOUR_LOST, Cause.COORDINATOR_LOST})


@dataclass(slots=True)
class Views:
    """What is known so far; calls `count` for each situation."""

    count: Callable[[Situation], None]
    fence: FenceChanged = FIRST
    order: tuple[int, ...] = ()
    """The newest strand that was to drive, leader first."""
    _proposed: defaultdict[int, set[int]] = field(default_factory=lambda: defaultdict(set))
    """The robots that have raised each generation."""
    _taken: set[int] = field(default_factory=set)
    """The epochs that came into force."""
    _formed: dict[int, StrandFormed] = field(default_factory=dict)
    _is_over: bool = False
    """Whether the robot that has the turn has said so."""
    _awaited: set[int] = field(default_factory=set)
    """The members that have not yet taken their places."""
    _all_s: float = 0.0
    _ended_by: Situation | None = None
    """What the newest view is to do to the strand."""
    _cause: Cause | None = None
    _down: set[int] = field(default_factory=set)

    @property
    def forms(self) -> bool:
        """Rule 2."""
        return self.fence.epoch > 0 and self.fence.may in {May.NOBODY, May.ONE}

    def hear(self, source: str, t_s: float, record: Record) -> None:
        """Read the next entry."""
        robot = robot_number(source)
        match record:
            case FenceChanged() if source == WORLD:
                self._change(t_s, record)
            case FaultInjected(fault=fault, process=str(process)) if source == WORLD:
                self._strike(t_s, fault, process)
            case FaultInjected(fault="partition", key=str(key)) if key.startswith("view/") and self.forms:
                self.count(Situation.CUT_WHILE_FORMING)
            case StrandFormed():
                self._formed.setdefault(record.epoch, record)
            case RobotStranded():
                self.count(Situation.STRANDED)
            case _ if robot is not None:
                self._hear_robot(robot, t_s, record)
            case _:
                pass

    def _hear_robot(self, robot: int, t_s: float, record: Record) -> None:
        match record:
            case ViewProposed(epoch=epoch):
                others = self._proposed[epoch // NUMBERS] - {robot}
                if others and robot not in self._proposed[epoch // NUMBERS]:
                    self.count(Situation.RAISES_CROSSED)
                self._proposed[epoch // NUMBERS].add(robot)
            case StrandJoined(epoch=epoch) if epoch == self.fence.epoch and robot in self._awaited:
                self._awaited.discard(robot)
                if t_s - self._all_s > ACTS_S:
                    self.count(Situation.FORMATION_LOST)
            case RobotPlaced(turn=turn) | RobotBlocked(turn=turn) if turn == self.fence.turn:
                self._is_over = True
            case StrandReversed():
                self._ended_by = Situation.TURNED_ROUND
            case StrandDissolved():
                self._ended_by = Situation.DISSOLVED
            case ViewLeft():
                self.count(Situation.LEFT_OUT)
            case _:
                pass

    # --- fences ---------------------------------------------------------------------------------------

    def _change(self, t_s: float, fence: FenceChanged) -> None:
        before, self.fence = self.fence, fence
        if fence.cause is not None:
            self._raise(t_s, before, fence, fence.cause)
        elif before.may is May.ONE and not self._is_over:
            self.count(Situation.TURN_TAKEN_BACK)
        if fence.may is May.ONE:
            self.count(Situation.TURN_GIVEN)
            self._is_over = False
        elif fence.may is May.ALL:
            self._drive(t_s, fence)

    def _raise(self, t_s: float, before: FenceChanged, fence: FenceChanged, cause: Cause) -> None:
        """A new epoch comes into force."""
        if (situation := OF_CAUSE.get(cause)) is not None:
            self.count(situation)
        generation = fence.epoch // NUMBERS
        if generation == before.epoch // NUMBERS:
            self.count(Situation.EPOCH_REPLACED)
        elif before.epoch > 0 and before.may in {May.NOBODY, May.ONE}:
            self.count(Situation.VIEW_ENDED_EARLY)
        if before.may is May.ONE:
            self.count(Situation.RAISED_IN_TURN)
        if before.may is May.ALL and t_s - self._all_s > ACTS_S:
            for _ in self._awaited - self._down:
                self.count(Situation.FORMATION_LOST)
        self._taken.add(fence.epoch)
        for each in [each for each in self._proposed if each < generation]:
            for robot in self._proposed.pop(each):
                if each * NUMBERS + robot not in self._taken:
                    self.count(Situation.RAISE_IN_VAIN)
        self._awaited.clear()
        self._cause = cause

    def _drive(self, t_s: float, fence: FenceChanged) -> None:
        """A strand may drive."""
        formed = self._formed.get(fence.epoch)
        before, self.order = set(self.order), self.order if formed is None else formed.order
        if self._ended_by is not None:
            self.count(self._ended_by)
            self._ended_by = None
        if self._cause is Cause.PLEA and set(self.order) - before:
            self.count(Situation.LET_IN)
        self._awaited, self._all_s = set(self.order), t_s

    # --- processes ------------------------------------------------------------------------------------

    def _strike(self, t_s: float, fault: str, process: str) -> None:
        robot = robot_number(process)
        match fault:
            case "kill" if robot is not None:
                self._kill(t_s, robot)
            case "kill" if self.forms:
                is_world = process == WORLD
                self.count(Situation.WORLD_LOST_IN_VIEW if is_world else Situation.ROUTER_LOST_IN_VIEW)
            case "freeze" if robot is not None:
                self._down.add(robot)
                if robot == self.fence.coordinator and self.forms:
                    self.count(Situation.COORDINATOR_FROZEN)
            case "start" | "thaw" if robot is not None:
                self._down.discard(robot)
                if fault == "start":
                    self._start(robot)
            case _:
                pass

    def _kill(self, t_s: float, robot: int) -> None:
        self._down.add(robot)
        fence = self.fence
        if robot == fence.coordinator:
            if fence.may is May.NOBODY:
                self.count(Situation.COORDINATOR_KILLED_BOUND)
            elif fence.may is May.ONE:
                self.count(Situation.COORDINATOR_KILLED_JOINING)
            elif fence.may is May.ALL:
                self.count(Situation.COORDINATOR_KILLED_DRIVING)
        if fence.may is May.ONE:
            is_own = robot == fence.named
            self.count(Situation.KILLED_IN_OWN_TURN if is_own else Situation.KILLED_IN_TURN)
        drives = fence.may is May.ALL
        acts = fence.named if drives else fence.coordinator
        if robot == acts and self._cause in LOSSES and not (drives and t_s - self._all_s > SUCCEEDS_S):
            self.count(Situation.KILLED_IN_SUCCESSION)

    def _start(self, robot: int) -> None:
        if self.fence.may is May.ONE and robot == self.fence.named:
            self.count(Situation.RESTARTED_IN_TURN)
        if self.forms and robot == self.fence.coordinator:
            self.count(Situation.COORDINATOR_RESTARTED)
