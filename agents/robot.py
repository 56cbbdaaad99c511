"""One robot. Pure: events in, commands out; no clock, no network, no chance.

Rule 1: whatever happens, silent links are looked for first, then the event is taken in, then the robot
        does what its state asks for. So a lost message costs time and nothing else: the next event
        finds the same state and acts on it.
Rule 2: every odometry is answered with the newest drive order.
Rule 3: while lining up a robot stands; in the strand it leads or follows, by its rank.
"""

from typing import assert_never

import numpy as np

from agents.commands import AskScan, Command, Note, Order
from agents.driver import Driver
from agents.events import Event, LinkHeard, MusterHeard, OdometryHeard, ScanHeard
from agents.follower import THERE_M, Follower
from agents.leader import Leader
from agents.lining import Lining
from agents.scan import View, view
from agents.step import Crossed, NoStep
from agents.strand import Own, Strand
from protocol.arrays import Floats
from protocol.messages import AheadState, Scan
from protocol.mission import Mission
from protocol.timeline import (
    GoalReached,
    RobotArrived,
    RobotHeld,
    RobotReleased,
    RouteLost,
    StepPlanned,
    StrandFormed,
)

SCAN_RETRY_S = 0.5  # a question or its answer may be lost; the sensor itself answers within a tick
RELEASE_SHARE = 0.9  # of the link's length: so that a robot at the limit does not stop and go


class Robot:
    """The decisions of one robot."""

    def __init__(self, robot: int, mission: Mission) -> None:
        self._robot = robot
        self._mission = mission
        self._driver = Driver(speed_mps=mission.speed_mps)
        self._lining = Lining(robot, mission)
        self._strand: Strand | None = None
        self._leader: Leader | None = None
        self._follower = Follower(mission)
        self._step: StepPlanned | None = None
        self._held = False
        self._arrived = False
        self._lost = False
        self._scan: Scan | None = None
        self._asked_at_s = -float("inf")

    def handle(self, event: Event, now_s: float) -> list[Command]:
        """Take in what happened; returns what is to be done, in order."""
        commands = self._strand.watch(now_s) if self._strand is not None else []
        match event:
            case OdometryHeard(odometry):
                self._driver.hear(odometry)
            case ScanHeard(scan):
                self._scan = scan
            case MusterHeard(robot, muster):
                self._lining.hear(robot, muster)
            case LinkHeard():
                commands += self._hear_link(event, now_s)
            case _:
                assert_never(event)
        if not self._driver.awake:
            return commands
        before = self._driver.drive.number
        commands += self._line_up(now_s) if self._strand is None else self._act(self._strand, now_s)
        if isinstance(event, OdometryHeard) or self._driver.drive.number != before:
            commands.append(Order(self._driver.drive))
        return commands

    def _hear_link(self, heard: LinkHeard, now_s: float) -> list[Command]:
        if self._strand is not None:
            return self._strand.hear(heard, now_s)
        order = self._lining.order
        if isinstance(heard.state, AheadState) and order and order[0] != self._robot:
            strand, commands = self._form(order, now_s)
            return commands + strand.hear(heard, now_s)
        return []

    # --- lining up ----------------------------------------------------------------------------------

    def _line_up(self, now_s: float) -> list[Command]:
        commands = self._lining.announce(self._driver.odometry.pose, self._take_scan(), now_s)
        if self._lining.wants_scan:
            commands += self._ask(now_s)
        if self._lining.may_lead:
            commands += self._form(self._lining.order, now_s)[1]
            if self._lining.folds_back:
                self._lost = True
                commands.append(Note(RouteLost(reason="from these places the way to the front is blocked")))
        return commands

    def _form(self, order: tuple[int, ...], now_s: float) -> tuple[Strand, list[Command]]:
        strand = Strand(self._robot, order, self._lining.places, self._mission, now_s)
        self._strand = strand
        self._driver.progress_m = strand.start_m
        if strand.ahead is None:
            self._leader = Leader(self._mission, self._lining.places[self._robot])
        formed = StrandFormed(
            epoch=strand.epoch, sensed=self._lining.sensed, order=order, path_length_m=strand.path.end_m
        )
        return strand, [Note(formed)]

    # --- in the strand ------------------------------------------------------------------------------

    def _act(self, strand: Strand, now_s: float) -> list[Command]:
        commands = self._hold(strand)
        if strand.silent or self._held:
            self._driver.stand()
        elif self._leader is not None:
            commands += self._lead(self._leader, strand, now_s)
        else:
            commands += self._follow(strand, now_s)
        own = Own(self._driver.progress_m, self._driver.odometry.pose, self._arrived)
        return commands + strand.tell(own, now_s)

    def _hold(self, strand: Strand) -> list[Command]:
        """The stretch rule: wait for a follower that is too far behind what it has been granted."""
        limit_m = self._mission.link_length_m_max * (RELEASE_SHARE if self._held else 1.0)
        if (strand.stretch_m > limit_m) == self._held:
            return []
        self._held = not self._held
        return [Note(RobotHeld(behind_m=strand.stretch_m) if self._held else RobotReleased())]

    def _lead(self, leader: Leader, strand: Strand, now_s: float) -> list[Command]:
        if self._arrived or self._lost or not self._driver.standing:
            return []
        step = self._step
        if step is not None and self._driver.progress_m < step.reach_m:
            self._driver.to(step.target, reach_m=step.reach_m, epoch=strand.epoch, step=step.step)
            return []
        self._step = None
        return self._plan(leader, strand, now_s)

    def _plan(self, leader: Leader, strand: Strand, now_s: float) -> list[Command]:
        if leader.is_done(self._position()):
            return [Note(GoalReached(**self._here())), *self._arrive()]
        scan = self._take_scan()
        if scan is None:
            return self._ask(now_s)
        planned = leader.plan(scan, strand.ground)
        match planned:
            case NoStep(reason):
                self._lost = True
                return [Note(RouteLost(reason=reason))]
            case Crossed():
                return [Note(GoalReached(**self._here())), *self._arrive()]
            case _:
                return self._begin(planned, strand)

    def _begin(self, planned: StepPlanned, strand: Strand) -> list[Command]:
        self._step = planned
        strand.path.extend(planned.target)
        self._driver.to(planned.target, reach_m=planned.reach_m, epoch=strand.epoch, step=planned.step)
        return [Note(planned)]

    def _follow(self, strand: Strand, now_s: float) -> list[Command]:
        assert strand.ahead is not None
        assert strand.ahead.state is not None, "a link that has not been heard is silent"
        driver, final = self._driver, strand.ahead.state.arrived
        if not driver.standing and driver.drive.target is None:
            return []  # it is being stopped
        ordered_m = driver.progress_m if driver.standing else driver.drive.reach_m
        reach_m = self._follower.reach_m(
            strand.path,
            progress_m=driver.progress_m,
            ordered_m=ordered_m,
            authority_m=strand.authority_m,
            final=final,
        )
        if reach_m is None:
            return self._arrive() if final and driver.standing else []
        reach_m = strand.claim_m(reach_m, progress_m=ordered_m)
        if reach_m <= ordered_m + THERE_M:
            return []  # a robot behind stands in the way, and may not go first
        if not self._follower.is_clear(reach_m):
            return self._check(strand, now_s)
        driver.to(strand.path.at(reach_m), reach_m=reach_m, epoch=strand.epoch)
        return []

    def _check(self, strand: Strand, now_s: float) -> list[Command]:
        """Check the segment that begins where the robot stands; until then it stands."""
        scan = self._take_scan()
        if scan is None:
            return self._ask(now_s) if self._follower.may_check(now_s) else []
        checked = self._follower.check(
            scan,
            strand.path,
            progress_m=self._driver.progress_m,
            authority_m=strand.authority_m,
            own_leg_m=strand.ahead_start_m,
            now_s=now_s,
        )
        return [Note(checked)]

    def _arrive(self) -> list[Command]:
        if self._arrived:
            return []
        self._arrived = True
        return [Note(RobotArrived(progress_m=self._driver.progress_m))]

    # --- small things -------------------------------------------------------------------------------

    def _ask(self, now_s: float) -> list[Command]:
        if now_s - self._asked_at_s < SCAN_RETRY_S:
            return []
        self._asked_at_s = now_s
        return [AskScan(self._mission.revolutions)]

    def _take_scan(self) -> View | None:
        """The scan that has come, if one has. It is used once, and only where it was taken.

        A question that was repeated may be answered twice, and the second answer may come when the robot
        stands somewhere else.
        """
        scan, self._scan = self._scan, None
        if scan is None or scan.pose != self._driver.odometry.pose:
            return None
        self._asked_at_s = -float("inf")
        return view(scan, range_m_max=self._mission.range_m_max)

    def _position(self) -> Floats:
        pose = self._driver.odometry.pose
        return np.array([pose.x_m, pose.y_m])

    def _here(self) -> dict[str, float]:
        pose = self._driver.odometry.pose
        return {"x_m": pose.x_m, "y_m": pose.y_m}
