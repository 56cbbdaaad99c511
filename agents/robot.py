"""One robot. Pure: events in, commands out; no clock, no network, no chance.

Rule 1: whatever happens, silent links are looked for first, then the event is taken in, then the robot does
        what its state asks for. So a lost message costs time only: the next event finds the same state.
Rule 2: every odometry is answered with the newest drive order.
Rule 3: it lines up (`agents.membership.lining`), or has its place in the strand and does its part there
        (`agents.strand.member`), or stands aside, in neither.
Rule 4: when the strand has dissolved it lines up again, in the next epoch, which the tail opens, since it is
        told last. So all orders of one epoch end before the first of the next.
Rule 5: a robot whose link is broken leaves the strand and calls all to line up (`agents.membership.calls`).
        Who hears of a newer epoch leaves what it is in: for that one if it is a member, else it stands aside
        and asks.
Rule 6: one that is started again begins aside, and answers only calls that were made since.
Rule 7: members that are no more than half of the robots that show tokens stand, and call.
"""

import math
from typing import assert_never

from protocol.epochs import is_called_since, of_one_call

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.body.watch import Watch
from agents.commands import Announce, Command, Note, Order
from agents.due import is_due
from agents.events import Event, LinkHeard, MusterHeard, OdometryHeard, ScanHeard, TokenCame, TokenWent
from agents.membership.berth import Berth
from agents.membership.calls import ASIDE_S, RANK_S, Calls
from agents.membership.lining import Lining
from agents.membership.muster import is_order
from agents.refusing import refusal
from agents.strand.forming import as_record, lined_up
from agents.strand.member import Member
from agents.strand.memory import Memory
from protocol.mission import Mission
from protocol.timeline import LeaderSucceeded, LinkBroken, MusterCalled, MusterJoined
from protocol.wire.link import Link
from protocol.wire.messages import (
    FIRST_ATTEMPT,
    FORMERS_MAX,
    AheadState,
    Announcement,
    Attempt,
    Beacon,
    BehindState,
    Muster,
    Odometry,
    Plea,
)

LATE_S = 5.0  # with half of all odometry lost, a robot that was there from the start has had some
BEACON_S = 1.0  # how often a leader says that it leads, and a robot aside that it is there


class Robot:
    """The decisions of one robot."""

    def __init__(self, robot: int, mission: Mission, *, again: bool = False) -> None:
        self._robot = robot
        self._mission = mission
        self._driver = Driver(speed_mps=mission.speed_mps, watched=mission.obstacles_move)
        self._senses = Senses(mission, self._driver)
        self._watch = Watch(mission, self._driver, self._senses)
        self._memory = Memory(mission)
        self._calls = Calls(robot, mission)
        self._again = again
        self._since_s: float | None = None
        self._lining: Lining | None = Lining(robot, mission)
        self._member: Member | None = None
        self._left = -1
        self._led_by: int | None = None
        self._berths: tuple[Berth, ...] = ()
        self._next_attempt = FIRST_ATTEMPT
        self._said_at_s = -BEACON_S

    @property
    def epoch(self) -> int:
        """What it is in, or was in before it stood aside."""
        if self._member is not None:
            return self._member.strand.epoch
        return self._lining.epoch if self._lining is not None else self._left

    @property
    def _members(self) -> tuple[int, ...]:
        """Who is in what it is in."""
        if self._member is not None:
            return self._member.strand.order
        return () if self._lining is None else self._lining.members

    def handle(self, event: Event, now_s: float) -> list[Command]:
        """Take in what happened; returns what is to be done, in order."""
        self._calls.enter(now_s)
        before = self._driver.drive
        commands = self._look_at_links(now_s)
        if refused := refusal(event, self._robot, now_s):
            return commands + (
                [] if self._since_s is None else [Note(refused)]
            )  # it may not know the time yet
        match event:
            case OdometryHeard(odometry):
                self._driver.hear(odometry)
                self._begin(odometry, now_s)
            case ScanHeard(scan):
                self._senses.hear(scan)
            case MusterHeard(robot, said):
                commands += self._hear_announcement(robot, said, now_s)
            case LinkHeard():
                commands += self._hear_link(event, now_s)
            case TokenCame(robot, incarnation):
                self._calls.presence.come(robot, incarnation, now_s)
            case TokenWent(robot, incarnation):
                self._calls.presence.go(robot, incarnation, now_s)
            case _:
                assert_never(event)
        if not self._driver.awake:
            return commands
        commands += self._stay_lawful(now_s) + self._heal(now_s) + self._act(now_s)
        if isinstance(event, OdometryHeard) or self._driver.drive != before:
            commands.append(Order(self._driver.drive))
        return commands

    def _begin(self, odometry: Odometry, now_s: float) -> None:
        """Rule 6, with the first odometry."""
        if self._since_s is None:
            self._since_s = -math.inf
            if self._again or odometry.ordered > 0 or odometry.t_s > LATE_S:
                self._since_s = now_s
                self._stand_aside(now_s)
                self._driver.start_again()

    def _act(self, now_s: float) -> list[Command]:
        """Do what the state asks for."""
        member = self._member
        if member is not None and member.dissolves and member.strand.behind is None:
            self._line_up_again(member, now_s)
        if self._lining is not None:
            return self._line_up(self._lining, now_s)
        if self._member is None:
            self._driver.stand()
            return self._say_now_and_then(Plea(epoch=self._calls.newest, t_s=now_s), now_s)
        strand = self._member.strand
        beacon = Beacon(epoch=strand.epoch, t_s=now_s)
        beacons = self._say_now_and_then(beacon, now_s) if strand.ahead is None else []
        return beacons + self._member.act(now_s)

    def _say_now_and_then(self, said: Beacon | Plea, now_s: float) -> list[Command]:
        if not is_due(last_s=self._said_at_s, every_s=BEACON_S, now_s=now_s):
            return []
        self._said_at_s = now_s
        return [Announce(said)]

    # --- hearing ------------------------------------------------------------------------------------

    def _hear_announcement(self, robot: int, said: Announcement, now_s: float) -> list[Command]:
        self._calls.hear(said.epoch, now_s)
        match said:
            case Muster():
                return self._hear_muster(robot, said, now_s)
            case Beacon():
                return self._hear_beacon(said, now_s)
            case Plea():
                return self._hear_plea(robot, said, now_s)
            case _:
                assert_never(said)

    def _hear_muster(self, robot: int, muster: Muster, now_s: float) -> list[Command]:
        commands: list[Command] = []
        member = self._member
        if member is not None and member.dissolves and muster.epoch == member.strand.epoch + 1:
            self._line_up_again(member, now_s)
        elif muster.members and self._heeds(muster.epoch):
            commands = self._leave_for(muster, now_s)
        if self._lining is not None:
            self._lining.hear(robot, muster, now_s)
        elif self._member is None:
            self._calls.beacon_at_s = now_s  # others are about to have a strand
        return commands

    def _heeds(self, epoch: int) -> bool:
        """Whether a call is one to answer: the newest that has been heard, and made in this robot's life."""
        if self._since_s is None:
            return False  # it does not know the time yet; the call is said again
        newest = epoch > self.epoch and epoch == self._calls.newest
        return newest and is_called_since(epoch, self._since_s)

    def _leave_for(self, muster: Muster, now_s: float) -> list[Command]:
        """Rule 5: there is a newer epoch, and who is called says whether this robot is."""
        if self._robot in muster.members:
            return self._bind(muster.epoch, muster.members, now_s, muster.attempt)
        self._stand_aside(now_s)
        return []

    def _hear_beacon(self, beacon: Beacon, now_s: float) -> list[Command]:
        if self._lining is None and self._member is None:
            self._calls.beacon_at_s = now_s
            return [Announce(Plea(epoch=beacon.epoch, t_s=now_s))]
        if beacon.epoch > self.epoch and not of_one_call(beacon.epoch, self.epoch):
            self._stand_aside(now_s)
        return []

    def _hear_plea(self, robot: int, plea: Plea, now_s: float) -> list[Command]:
        self._calls.pleads(robot, plea.epoch, now_s)
        if not self._has_place_for(robot, plea) or not self._calls.invites(robot, now_s):
            return []
        return self._call(f"robot {robot} asks to join", now_s)

    def _has_place_for(self, robot: int, plea: Plea) -> bool:
        """Whether this robot leads a strand without the one that asks, or is stuck without it."""
        if self._member is not None:
            strand = self._member.strand
            leads = strand.ahead is None and plea.epoch == strand.epoch
            return leads and robot not in strand.order and not self._member.leaves_dead_end
        lining = self._lining
        return lining is not None and lining.stuck_at_s is not None and robot not in lining.members

    def _hear_link(self, heard: LinkHeard, now_s: float) -> list[Command]:
        self._calls.hear(heard.state.epoch, now_s)
        if self._member is not None:
            return self._member.hear(heard, now_s)
        lining, state = self._lining, heard.state
        if lining is None or not isinstance(state, AheadState) or state.epoch != lining.epoch + 1:
            return []
        if lining.order[:1] in ((), (self._robot,)) or lining.free_at_s is None:
            return []
        member, commands = self._form(lining, now_s)
        return commands + member.hear(heard, now_s)

    # --- healing ------------------------------------------------------------------------------------

    def _stay_lawful(self, now_s: float) -> list[Command]:
        """Rule 7."""
        members = self._members
        if not members or self._calls.may_go_on(members, now_s):
            return []
        return self._call("too many that are left out show tokens", now_s)

    def _heal(self, now_s: float) -> list[Command]:
        """Rule 5."""
        if not self._calls.is_awake:
            return []
        if self._member is not None:
            return self._leave_strand(self._member, now_s)
        if self._lining is not None:
            return self._leave_lining(self._lining, now_s)
        quiet_s = now_s - self._calls.beacon_at_s
        if quiet_s > ASIDE_S + RANK_S * self._robot and self._calls.is_heard(now_s):
            return self._call("nobody leads", now_s)
        return []

    def _leave_lining(self, lining: Lining, now_s: float) -> list[Command]:
        why = self._calls.wants_another(lining, now_s)
        if why is not None:
            return self._call(why, now_s)
        why = "no way to a place behind this robot"
        if lining.goes_on_with:
            return self._call(why, now_s, attempt=lining.attempt, among=lining.goes_on_with)
        if lining.wants_another_order:
            return self._call(why, now_s, attempt=lining.next_attempt, among=lining.members)
        return []

    def _look_at_links(self, now_s: float) -> list[Command]:
        """Say which links are silent; leave the strand for good where one has been for too long."""
        if self._member is None:
            return []
        strand, mission = self._member.strand, self._mission
        commands = strand.watch(now_s)
        for link in strand.links:
            silent_s = link.silent_s(now_s)
            if silent_s > mission.silence_s + mission.patience_s or strand.keeps_waiting(link):
                if strand.stands_out(link):
                    self._calls.broke(link.neighbour, now_s, since_s=now_s - silent_s)
                return commands + self._break(link, "silence", now_s)
        return commands

    def _leave_strand(self, member: Member, now_s: float) -> list[Command]:
        """Leave it where a neighbour's process is no more, or where another robot may know a way on."""
        if member.wants_another_order:
            why, among = "this robot knows no way on", member.strand.order
            return self._call(why, now_s, attempt=self._next_attempt, among=among)
        for link in member.strand.links:
            if self._calls.presence.is_lost(link.neighbour, max(link.heard_at_s, link.made_at_s), now_s):
                return self._break(link, "token", now_s)
        return []

    def _break(self, link: Link[AheadState] | Link[BehindState], cause: str, now_s: float) -> list[Command]:
        broken = LinkBroken(neighbour=link.neighbour, cause=cause, silent_s=link.silent_s(now_s))
        return [Note(broken), *self._call(f"robot {link.neighbour} is lost", now_s)]

    def _call(
        self, why: str, now_s: float, *, attempt: Attempt = FIRST_ATTEMPT, among: tuple[int, ...] = ()
    ) -> list[Command]:
        """Call a muster: of all, or of those alone that have answered, for another order."""
        if not (self._driver.awake and self._calls.is_awake and self._calls.is_heard(now_s)):
            self._stand_aside(now_s)
            return []
        epoch, members = self._calls.call(self._lining, now_s, among=among)
        if self._robot not in members:  # it is the one that the others do not hear: one of them will call
            self._stand_aside(now_s)
            return []
        self._calls.newest = epoch
        called = MusterCalled(epoch=epoch, members=members, why=why)
        return [Note(called), *self._bind(epoch, members, now_s, attempt)]

    def _bind(self, epoch: int, members: tuple[int, ...], now_s: float, attempt: Attempt) -> list[Command]:
        """Leave whatever this robot is in, for a muster that has been called."""
        self._leave()
        self._calls.bind(members)
        self._lining = Lining(
            self._robot,
            self._mission,
            now_s,
            epoch=epoch,
            members=members,
            shunned=self._calls.shunned(now_s),
            berths=self._berths,
            attempt=attempt,
        )
        return [Note(MusterJoined(epoch=epoch))]

    def _stand_aside(self, now_s: float) -> None:
        self._leave()
        self._lining = None
        self._calls.stand_aside(now_s)

    def _leave(self) -> None:
        self._left = self.epoch
        if self._member is not None:
            strand, speed_mps = self._member.strand, self._mission.speed_mps
            progress_m = min(self._driver.progress_m, strand.path.end_m)
            rank = strand.order.index(self._robot)
            berth = Berth(strand.epoch, rank, progress_m, strand.path, speed_mps, self._member.arrived)
            self._berths = (berth, *(() if self._member.has_moved else self._berths))[:FORMERS_MAX]
        elif self._lining is not None:
            self._berths = self._lining.berths
        self._member = None
        self._driver.begin(0.0)
        self._senses.forget()

    # --- lining up ----------------------------------------------------------------------------------

    def _line_up_again(self, member: Member, now_s: float) -> None:
        """Rule 4."""
        strand = member.strand
        assert strand.dissolution is not None, "nobody leaves a strand before it has been told"
        self._memory.part(strand.dissolution)
        self._leave()
        everybody = len(strand.order) == self._mission.robots
        members = () if everybody else tuple(sorted(strand.order))
        self._lining = Lining(self._robot, self._mission, now_s, epoch=strand.epoch + 1, members=members)

    def _line_up(self, lining: Lining, now_s: float) -> list[Command]:
        self._calls.attend(lining, self._driver, now_s)
        scan = self._senses.take() if self._driver.standing else None
        commands = lining.act(self._driver, scan, now_s)
        if lining.finds_no_way:
            self._calls.forgive(lining.members)
        if lining.wants_scan(self._driver):
            commands += self._senses.ask(now_s)
        if lining.all_are_bound:
            commands += self._watch.look(lining.beside, now_s)
            if self._watch.gives_up(now_s):
                lining.give_up_step(self._driver)
        if lining.may_lead and lining.free_at_s is not None:
            commands += self._form(lining, now_s)[1]
        return commands

    def _form(self, lining: Lining, now_s: float) -> tuple[Member, list[Command]]:
        order = lining.order
        assert lining.free_at_s is not None, "nobody leaves a lining up before it is known when it may drive"
        strand = lined_up(
            self._robot,
            order,
            lining.places,
            self._mission,
            now_s,
            epoch=lining.epoch + 1,
            legs=lining.legs,
            driven=lining.leg_is_driven,
        )
        self._member = Member(
            self._mission,
            self._driver,
            self._senses,
            strand,
            self._memory,
            free_at_s=lining.free_at_s,
            other_orders=lining.is_called and is_order(lining.next_attempt, len(order)),
        )
        self._berths, self._next_attempt = lining.berths, lining.next_attempt
        self._lining = None
        self._driver.begin(strand.start_m)
        bent = bool(lining.legs) and order[0] == self._robot
        commands: list[Command] = [Note(as_record(strand, sensed=lining.sensed, bent=bent))]
        if lining.is_called and order[0] == self._robot != self._led_by:
            commands.append(Note(LeaderSucceeded(epoch=strand.epoch, before=self._led_by)))
        self._led_by = order[0]
        look, promises = lining.look, self._mission.law.promises_clearance
        if strand.ahead is not None and promises and look is not None and look.t_s >= lining.free_at_s:
            commands.append(self._member.take_look(look, now_s))
        return self._member, commands
