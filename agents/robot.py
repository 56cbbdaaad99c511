"""One robot. Pure: events in, commands out; no clock, no network, no chance.

Rule 1: whatever happens, silent links are looked for first, then the event is taken in, then the robot
        does what its state asks for. So a lost message costs time and nothing else: the next event
        finds the same state and acts on it.
Rule 2: every odometry is answered with the newest drive order.
Rule 3: first it lines up (`agents.lining`); from when it has its place in the strand it does its part there
        (`agents.member`).
Rule 4: when the strand has dissolved it lines up again, in the next epoch. The tail, which is told last,
        opens that; every other robot that has been told joins in when it hears of it. So nobody lines up
        before all stand for good, and the orders of one epoch end before the next one's begin.
"""

from typing import assert_never

from agents.commands import Command, Note, Order
from agents.driver import Driver
from agents.events import Event, LinkHeard, MusterHeard, OdometryHeard, ScanHeard
from agents.lining import Lining
from agents.member import Member
from agents.memory import Memory
from agents.senses import Senses
from agents.strand import lined_up
from agents.watch import Watch
from protocol.messages import AheadState, Muster
from protocol.mission import Mission
from protocol.timeline import StrandFormed


class Robot:
    """The decisions of one robot."""

    def __init__(self, robot: int, mission: Mission) -> None:
        self._robot = robot
        self._mission = mission
        self._driver = Driver(speed_mps=mission.speed_mps, watched=mission.obstacles_move)
        self._senses = Senses(mission, self._driver)
        self._watch = Watch(mission, self._driver, self._senses)
        self._memory = Memory(mission)
        self._lining = Lining(robot, mission)
        self._member: Member | None = None

    def handle(self, event: Event, now_s: float) -> list[Command]:
        """Take in what happened; returns what is to be done, in order."""
        commands = self._member.strand.watch(now_s) if self._member is not None else []
        match event:
            case OdometryHeard(odometry):
                self._driver.hear(odometry)
            case ScanHeard(scan):
                self._senses.hear(scan)
            case MusterHeard(robot, muster):
                self._hear_muster(robot, muster, now_s)
            case LinkHeard():
                commands += self._hear_link(event, now_s)
            case _:
                assert_never(event)
        if not self._driver.awake:
            return commands
        before = self._driver.drive
        if self._member is not None and self._member.dissolves and self._member.strand.behind is None:
            self._line_up_again(self._member)
        commands += self._line_up(now_s) if self._member is None else self._member.act(now_s)
        if isinstance(event, OdometryHeard) or self._driver.drive != before:
            commands.append(Order(self._driver.drive))
        return commands

    def _hear_muster(self, robot: int, muster: Muster, now_s: float) -> None:
        member = self._member
        if member is not None and member.dissolves and muster.epoch == member.strand.epoch + 1:
            self._line_up_again(member)
        self._lining.hear(robot, muster, now_s)

    def _line_up_again(self, member: Member) -> None:
        """Rule 4."""
        assert member.strand.dissolution is not None, "nobody leaves a strand before it has been told"
        self._memory.part(member.strand.dissolution)
        self._member = None
        self._lining = Lining(self._robot, self._mission, epoch=member.strand.epoch + 1)
        self._driver.begin(0.0)
        self._senses.forget()

    def _hear_link(self, heard: LinkHeard, now_s: float) -> list[Command]:
        if self._member is not None:
            return self._member.hear(heard, now_s)
        order, state = self._lining.order, heard.state
        forms = isinstance(state, AheadState) and state.epoch == self._lining.epoch + 1
        if forms and order and order[0] != self._robot:
            member, commands = self._form(order, now_s)
            return commands + member.hear(heard, now_s)
        return []

    def _line_up(self, now_s: float) -> list[Command]:
        scan = self._senses.take() if self._driver.standing else None
        commands = self._lining.act(self._driver, scan, now_s)
        if self._lining.wants_scan(self._driver):
            commands += self._senses.ask(now_s)
        commands += self._watch.look(self._lining.beside, now_s)
        if self._watch.is_in_vain(now_s):
            self._lining.give_up_step(self._driver)
        if self._lining.may_lead:
            commands += self._form(self._lining.order, now_s)[1]
        return commands

    def _form(self, order: tuple[int, ...], now_s: float) -> tuple[Member, list[Command]]:
        lining = self._lining
        strand = lined_up(self._robot, order, lining.places, self._mission, now_s, epoch=lining.epoch + 1)
        self._member = Member(self._mission, self._driver, self._senses, strand, self._memory)
        self._driver.begin(strand.start_m)
        commands: list[Command] = [
            Note(
                StrandFormed(
                    epoch=strand.epoch, sensed=lining.sensed, order=order, path_length_m=strand.path.end_m
                )
            )
        ]
        if strand.ahead is not None and lining.look is not None and self._mission.law.promises_clearance:
            # The scan that showed its leg clear was taken right here: it need not be taken again.
            checked = self._member.follower.check(
                lining.look,
                strand.path,
                progress_m=strand.start_m,
                authority_m=strand.start_m,
                own_leg_m=strand.own_leg_m,
                now_s=now_s,
            )
            commands.append(Note(checked))
        return self._member, commands
