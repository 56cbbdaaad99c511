"""One robot's part in views: its state, and what it does in each.

Rule 1: the fence that the robot's own odometry tells decides everything: a newer epoch binds it, a turn that
        names this life lets it join, ALL and its formation make it a member. `states` is the table.
Rule 2: messages count only in the epoch that its odometry tells; answers and formations only from its
        coordinator.
Rule 3: coordinating is a role beside the state. A coordinator reports to itself as others do.
"""

from collections.abc import Iterable

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command, Note, Say
from agents.coordinating.coordinator import Coordinator
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from agents.membership.joining import Joining
from agents.membership.places import Past
from agents.membership.pleas import Pleas
from agents.membership.proposing import Proposing
from agents.membership.reporting import Reporter
from agents.membership.states import Happening, State, after
from agents.membership.turn import TurnTaker
from agents.strand.member import Member
from agents.strand.memory import Memory
from protocol.fence import NOBODY_NUMBER, Epoch, Fence, May, in_force
from protocol.mission import Mission
from protocol.timeline import ViewJoined, ViewLeft
from protocol.wire.view import Answer, Formation, Plea, Report, ViewMessage


class Membership:
    """The state of one robot in views."""

    def __init__(self, robot: int, life: int, mission: Mission, driver: Driver, senses: Senses) -> None:
        self._robot = robot
        self._life = life
        self._mission = mission
        self._driver = driver
        self._senses = senses
        self._timing = Timing.of(mission)
        self.suspicion = Suspicion(self._timing)
        self._pleas = Pleas(self._timing)
        self._proposing = Proposing(robot, life, self._timing, self.suspicion, self._pleas)
        self._memory = Memory(mission)
        self.state = State.BOUND
        self.member: Member | None = None
        self.coordinator: Coordinator | None = None
        self.fence = Fence()
        """The fence that its odometry tells."""
        self._reporter = Reporter(Epoch(), life, mission, self._timing, self._memory, Past(), heard_at_s=0.0)
        self._joining = Joining(mission)
        self._turn: TurnTaker | None = None
        self._own_number = 0

    # --- rule 1 -------------------------------------------------------------------------------------

    def begin(self, now_s: float) -> None:
        """The first odometry has come: the fence that it tells need not be a new one."""
        self._proposing.enter(self._driver.odometry.fence, now_s)

    def enter(self, now_s: float) -> list[Command]:
        """New odometry has come: take in the fence that it tells."""
        before, fence = self.fence, self._driver.odometry.fence
        if fence.key == before.key:
            return []
        self.fence = fence
        if self._turn is not None:
            self._joining.release()
            if self._turn.has_moved:
                self._reporter.leave_places()
            self._turn = None
        self._happen(Happening.NEWER_FENCE)
        self._proposing.enter(fence, now_s)
        commands = self._bind(now_s) if fence.epoch != before.epoch else []
        if fence.may is May.ONE and fence.names(self._robot, self._life):
            self._happen(Happening.NAMED)
        return commands

    def _happen(self, happening: Happening) -> None:
        self.state = after(self.state, happening)

    def _bind(self, now_s: float) -> list[Command]:
        """There is a newer epoch: leave whatever this robot is in."""
        self._happen(Happening.NEWER_EPOCH)
        epoch, past, member = self.fence.epoch, self._reporter.past, self.member
        if member is not None:
            past = past.with_strand(member)
        self.member = self.coordinator = None
        self._pleas.forget()
        self._senses.forget()
        self._reporter = Reporter(epoch, self._life, self._mission, self._timing, self._memory, past, now_s)
        if epoch.robot == NOBODY_NUMBER:
            return []
        if (epoch.robot, epoch.life) == (self._robot, self._life):
            self.coordinator = Coordinator(
                epoch,
                mission=self._mission,
                timing=self._proposing.timing,
                suspicion=self.suspicion,
                intent=self._proposing.intent(member, past.neighbours),
                now_s=now_s,
            )
        return [Note(ViewJoined(epoch=epoch.number))]

    # --- rule 2 -------------------------------------------------------------------------------------

    def hear(self, robot: int, number: int, said: ViewMessage, now_s: float) -> list[Command]:
        """Take in a message of a view."""
        if said.epoch != self.fence.epoch:
            return []
        reporter = self._reporter if robot == said.epoch.robot else None
        match said:
            case Report() if self.coordinator is not None:
                self.coordinator.hear(robot, said, now_s)
            case Plea():
                return self._hear_plea(robot, said, now_s)
            case Answer(heard=0) if robot == self.fence.robot:
                self._proposing.leader_answers(now_s)
            case Answer() if reporter is not None and said.life == self._life:
                reporter.hear(said, number, now_s)
                if said.out and self.state is State.BOUND:
                    self._happen(Happening.LEFT_OUT)
                    return [Note(ViewLeft(epoch=said.epoch.number))]
            case Formation() if reporter is not None and said.life == self._life:
                reporter.hear_formation(said, now_s)
            case _:
                pass  # from a robot that may not say so
        return []

    def _hear_plea(self, robot: int, plea: Plea, now_s: float) -> list[Command]:
        member = self.member
        if member is None or not member.leads:
            return []
        if robot not in self.suspicion.suppressed(now_s):
            stood_s, may_lead = self._driver.odometry.stood_s, member.lets_lead(robot)
            self._pleas.hear(robot, now_s, stood_s=stood_s, arrived=member.rests, may_lead=may_lead)
        return [Say(robot, Answer(epoch=plea.epoch, life=plea.life, heard=0, out=True))]

    # --- acting -------------------------------------------------------------------------------------

    def act(self, now_s: float) -> list[Command]:
        """What is to be done now."""
        if self.state is State.BOUND and self.fence.may is May.ALL:
            self._take_place(now_s)
        commands = self._do(now_s)
        if self.coordinator is not None:
            commands = self._deliver(commands, now_s)
            commands += self._deliver(self.coordinator.act(self._driver.odometry, now_s), now_s)
        return commands + self._proposing.act(self._driver.odometry, self._reporter, self.member, now_s)

    def _take_place(self, now_s: float) -> None:
        whole = self._reporter.assembly.whole
        if whole is None or whole[0].turn != self.fence.turn or not in_force(self.fence):
            return
        if (whole[0].rank == 0) is not (self.fence.robot == self._robot):
            return  # ALL names the leader: a coordinator that lies makes no second one
        self._happen(Happening.FORMED)
        formation, path = whole
        self._pleas.note_stranded(formation.stranded, now_s)
        self.member = Member(
            self._robot,
            mission=self._mission,
            driver=self._driver,
            senses=self._senses,
            memory=self._memory,
            formation=formation,
            path=path,
            now_s=now_s,
        )

    def _do(self, now_s: float) -> list[Command]:
        """What the state asks for."""
        match self.state:
            case State.MEMBER:
                assert self.member is not None, "a member has its place"
                return self.member.act(now_s)
            case State.JOINING:
                return self._join(now_s)
            case State.ASIDE:
                return self._plead(now_s)
            case State.BOUND:
                silent = self._proposing.is_silent(self._reporter, 3.0 * self._timing.plea_s, now_s)
                return self._report(now_s) + (self._plead(now_s) if silent else [])

    def _report(self, now_s: float) -> list[Command]:
        driver = self._driver
        driver.stand()
        if not driver.standing or self.fence.epoch.robot == NOBODY_NUMBER:
            return []
        return self._reporter.act(driver, self._senses, now_s)

    def _join(self, now_s: float) -> list[Command]:
        join = self._reporter.join(self.fence.turn)
        if join is None:
            return self._report(now_s)
        if self._turn is None:
            self._turn = TurnTaker(
                self._mission, self._driver, self._senses, self._joining, join, life=self._life
            )
        commands = self._turn.act(now_s)
        if self._turn.ended is None:
            return commands
        self._reporter.end_turn(self._turn.ended)
        return commands + self._report(now_s)

    def _plead(self, now_s: float) -> list[Command]:
        """Ask the leader that odometry names to be let in."""
        self._driver.stand()
        if self.fence.robot == self._robot:
            return []
        return self._pleas.ask(Plea(epoch=self.fence.epoch, life=self._life), self.fence, now_s)

    def _deliver(self, commands: Iterable[Command], now_s: float) -> list[Command]:
        """Rule 3: what a coordinator says to itself arrives at once."""
        others: list[Command] = []
        for command in commands:
            if isinstance(command, Say) and command.robot == self._robot:
                self._own_number += 1
                others += self.hear(self._robot, self._own_number, command.said, now_s)
            else:
                others.append(command)
        return others
