"""One robot. Pure: events in, commands out; no clock, no network, no chance.

Rule 1: whatever happens, the event is taken in, and then the robot does what its state asks for. So a lost
        message costs time only: the next event finds the same state.
Rule 2: every new odometry is answered with the newest drive order.
Rule 3: its state in views decides what it does (`agents.membership.membership`).
Rule 4: a process that replaces a dead one first orders its body to stand. The order's number is higher than
        all before.
"""

from collections.abc import Sequence
from typing import assert_never

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command, Order
from agents.coordinating.draft import Drafted
from agents.coordinating.phases import Phase
from agents.events import Event, LinkHeard, OdometryHeard, ScanHeard, TokensSeen, TokensWatched, ViewHeard
from agents.membership.membership import Membership
from agents.membership.states import State
from agents.strand.member import Member
from protocol.fence import Fence, Life, May
from protocol.mission import Mission
from protocol.process.tokens import TokenCame, TokenWent
from protocol.wire.link import Link
from protocol.wire.messages import AheadState, BehindState, Drive, Odometry

LATE_S = 5.0  # with half of all odometry lost, a robot that was there from the start has had some


class Robot:
    """The decisions of one robot."""

    def __init__(self, robot: int, mission: Mission, *, life: Life, again: bool = False) -> None:
        self._again = again
        self._driver = Driver(speed_mps=mission.speed_mps, watched=mission.obstacles_move)
        self._senses = Senses(mission, self._driver)
        self._membership = Membership(robot, life, mission, self._driver, self._senses)

    @property
    def awake(self) -> bool:
        """Whether it has had odometry."""
        return self._driver.awake

    @property
    def state(self) -> State:
        """What it does in the present view."""
        return self._membership.state

    @property
    def fence(self) -> Fence:
        """The fence that its odometry tells."""
        return self._membership.fence

    @property
    def coordinates(self) -> bool:
        """Whether it coordinates the present view."""
        return self._membership.coordinator is not None

    @property
    def leads(self) -> bool:
        """Whether it is the first of the strand."""
        return self._membership.member is not None and self._membership.member.leads

    @property
    def phase(self) -> Phase | None:
        """How far the view has come that it coordinates; None: it coordinates none."""
        coordinator = self._membership.coordinator
        return None if coordinator is None else coordinator.phase

    def drafted(self, now_s: float) -> Drafted | None:
        """What it has drafted as the coordinator of the present view; None: it coordinates none."""
        coordinator = self._membership.coordinator
        return None if coordinator is None else coordinator.drafted(now_s)

    @property
    def member(self) -> Member | None:
        """Its part in the strand; None: it has none."""
        return self._membership.member

    @property
    def odometry(self) -> Odometry | None:
        """The newest odometry; None: it has had none."""
        return self._driver.odometry if self.awake else None

    @property
    def order(self) -> Drive:
        """The newest order to its body."""
        return self._driver.drive

    @property
    def links(self) -> Sequence[Link[AheadState] | Link[BehindState]]:
        """Its links to its neighbours in the strand."""
        return () if self._membership.member is None else self._membership.member.strand.links

    @property
    def watches(self) -> frozenset[int] | None:
        """The robots whose tokens matter to it now; None: all of them."""
        coordinator, member = self._membership.coordinator, self._membership.member
        if coordinator is not None and coordinator.phase is not Phase.FORMED:
            return None
        if member is not None:
            return member.strand.linked
        is_left_out = self._driver.awake and self._driver.odometry.fence.may is May.ALL
        return frozenset({self._driver.odometry.fence.robot} if is_left_out else ())  # its leader's

    def handle(self, event: Event, now_s: float) -> list[Command]:
        """Take in what happened; returns what is to be done, in order."""
        before, begins = self._driver.drive, not self._driver.awake
        is_new = isinstance(event, OdometryHeard) and self._driver.hear(event.odometry)
        if self._driver.awake:
            self._membership.suspicion.live(now_s)
            if begins:
                self._begin(self._driver.odometry, now_s)
        commands = self._take_in(event, now_s, is_new=is_new)
        if not self._driver.awake:
            return commands
        commands += self._membership.act(now_s)
        changed = self._driver.drive is not before and self._driver.drive != before
        if (is_new or changed) and self._driver.tells:
            commands.append(Order(self._driver.drive))
        return commands

    def _begin(self, odometry: Odometry, now_s: float) -> None:
        """Rule 4."""
        self._membership.begin(now_s)
        if self._again or odometry.ordered > 0 or odometry.t_s > LATE_S:
            self._driver.start_again()

    def _take_in(self, event: Event, now_s: float, *, is_new: bool) -> list[Command]:
        membership, presence = self._membership, self._membership.suspicion.presence
        match event:
            case OdometryHeard():
                return membership.enter(now_s) if is_new else []
            case ScanHeard(scan):
                self._senses.hear(scan)
            case ViewHeard(robot, number, said):
                return membership.hear(robot, number, said, now_s)
            case LinkHeard():
                return [] if membership.member is None else membership.member.hear(event, now_s)
            case TokenCame(robot, incarnation):
                presence.come(robot, incarnation, now_s)
            case TokensSeen(shown):
                presence.see(shown, now_s)
            case TokensWatched(robots):
                presence.watch(robots, now_s)
            case TokenWent(robot, incarnation):
                presence.go(robot, incarnation, now_s)
            case _:
                assert_never(event)
        return []
