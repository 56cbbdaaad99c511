"""One robot's part in views: its state, what it reports, and when it proposes a view.

Rule 1: the fence that the robot's own odometry tells decides everything: a newer epoch binds it, a turn that
        names this life lets it join, ALL and its formation make it a member. `states` is the table.
Rule 2: messages count only in the epoch that its odometry tells; answers and formations only from its
        coordinator.
Rule 3: coordinating is a role beside the state. A coordinator reports to itself as others do.
Rule 4: a process that follows a dead one first has its body stand, by an order numbered beyond all before.
"""

from collections import Counter
from collections.abc import Iterable

import numpy as np

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command, Note, Say
from agents.due import is_due
from agents.membership.coordinator import Coordinator, Intent
from agents.membership.formation import Assembly
from agents.membership.joining import Joining
from agents.membership.places import Berth, Places
from agents.membership.questions import Questions
from agents.membership.raising import Raising, Reason
from agents.membership.reporting import Reporter
from agents.membership.states import Happening, State, after
from agents.membership.suspicion import Suspicion
from agents.membership.timing import Timing
from agents.membership.turn import TurnTaker
from agents.strand.member import Member
from agents.strand.memory import Memory
from protocol.fence import Bearing, Cause, Epoch, Fence, May, in_force
from protocol.mission import Mission
from protocol.timeline import LinkBroken, StrandDissolved, StrandReversed, ViewJoined, ViewLeft
from protocol.wire.view import Answer, Counters, Formation, Plea, Report, ViewMessage

LATE_S = 5.0  # with half of all odometry lost, a robot that was there from the start has had some
STOP_S = 5.0  # a leader lets a robot in at its next stop, or after this time


class Membership:
    """The state of one robot in views."""

    def __init__(
        self,
        robot: int,
        life: int,
        mission: Mission,
        driver: Driver,
        senses: Senses,
        *,
        again: bool,
    ) -> None:
        self._robot = robot
        self._life = life
        self._mission = mission
        self._driver = driver
        self._senses = senses
        self._timing = Timing.of(mission)
        self.suspicion = Suspicion(self._timing, mission.silence_s + mission.patience_s)
        self._raising = Raising(robot, life, self._timing)
        self._memory = Memory(mission)
        self.state = State.BOUND
        self.member: Member | None = None
        self.coordinator: Coordinator | None = None
        self._fence = Fence()
        self._again = again
        self._since_s: float | None = None
        """When it had its first odometry."""
        self._first_order = 0
        """Rule 4: the number of the order to stand."""
        self._entered_s = self._turned_s = 0.0
        """When its odometry first told this epoch, and this turn."""
        self._reporter: Reporter | None = None
        self._joining: Joining | None = None
        self._taker: TurnTaker | None = None
        self._assembly = Assembly()
        self._places = Places()
        self._counters, self._counted = Counters(), Epoch()
        self._arrived = False
        self._led_by = 0
        self._leader_heard_s = 0.0
        self._pleaded_s = -float("inf")
        self._plea: tuple[int, float] | None = None
        self._let_in: Counter[int] = Counter()
        self._not_before_s: dict[int, float] = {}

    # --- rule 1 -------------------------------------------------------------------------------------

    def enter(self, now_s: float) -> list[Command]:
        """New odometry has come: take in the fence that it tells."""
        odometry = self._driver.odometry
        self.suspicion.enter(now_s)
        self._begin(now_s)
        fence, before = odometry.fence, self._fence
        if fence.key == before.key and self._since_s != now_s:
            return []
        self._raising.enter(fence)
        self._fence, self._turned_s = fence, now_s
        commands: list[Command] = []
        if fence.epoch != before.epoch:
            commands = self._bind(now_s)
        if fence.may is May.ALL:
            self._led_by, self._leader_heard_s = fence.robot, now_s
        named = fence.may is May.ONE and fence.names(self._robot, self._life)
        if self._reporter is not None:
            self._reporter.be_named(named=named)
        self._happen(Happening.NAMED if named else Happening.NOT_NAMED)
        return commands

    def _begin(self, now_s: float) -> None:
        """Rule 4, with the first odometry."""
        if self._since_s is not None:
            return
        self._since_s = now_s
        odometry = self._driver.odometry
        if self._again or odometry.ordered > 0 or odometry.t_s > LATE_S:
            self._driver.start_again()
            self._first_order, self._again = self._driver.drive.number, True

    def _happen(self, happening: Happening) -> None:
        self.state = after(self.state, happening)
        if self.state is not State.JOINING:
            self._end_joining()

    def _bind(self, now_s: float) -> list[Command]:
        """There is a newer epoch: leave whatever this robot is in."""
        self._keep_places()
        self._happen(Happening.NEWER_EPOCH)
        epoch = self._fence.epoch
        self.member = self._reporter = self.coordinator = self._joining = None
        self._assembly, self._plea = Assembly(), None
        self._senses.forget()
        self._entered_s = now_s
        if epoch.robot == 0:
            return []
        self._reporter = Reporter(
            epoch=epoch,
            life=self._life,
            mission=self._mission,
            timing=self._timing,
            memory=self._memory,
            places=self._places,
            counters=self._counters,
            counted=self._counted,
            arrived=self._arrived,
            heard_at_s=now_s,
        )
        if (epoch.robot, epoch.life) == (self._robot, self._life):
            self.coordinator = Coordinator(
                robot=self._robot,
                epoch=epoch,
                mission=self._mission,
                timing=self._timing,
                suspicion=self.suspicion,
                intent=self._intent(),
                began_s=now_s,
                questions=Questions(self._mission, self._timing),
            )
        return [Note(ViewJoined(epoch=epoch.number))]

    def _keep_places(self) -> None:
        """What this robot is in has ended: keep its place there, as far as it has not left it."""
        member = self.member
        self._end_joining()
        if self._reporter is not None:
            self._places = self._reporter.places
        if member is not None:
            formation = member.formation
            berth = Berth(formation.epoch, formation.rank, member.progress_m, member.path)
            self._places = self._places.with_berth(berth, moved=member.has_moved)
            self._counters, self._counted = member.counters, formation.epoch
            self._arrived = member.arrived

    def _end_joining(self) -> None:
        taker, self._taker = self._taker, None
        if taker is not None and self._reporter is not None and taker.has_moved:
            self._reporter.leave_places()

    def _intent(self) -> Intent:
        """Why this robot has proposed the view."""
        reason, ended = self._raising.reason, self._ended_strand
        assert reason is not None, "who coordinates has proposed"
        turnabout, path = (None, None) if ended is None else ended
        return Intent(cause=reason.cause, led_by=self._led_by, turnabout=turnabout, path=path)

    # --- rule 2 -------------------------------------------------------------------------------------

    def hear(self, robot: int, number: int, said: ViewMessage, now_s: float) -> list[Command]:
        """Take in a message of a view."""
        if said.epoch != self._fence.epoch:
            return []
        match said:
            case Report():
                if self.coordinator is not None:
                    self.coordinator.hear(robot, said, now_s)
            case Plea():
                return self._hear_plea(robot, said, now_s)
            case Answer() if self._fence.may is May.ALL and robot == self._fence.robot and said.heard == 0:
                self._leader_heard_s = now_s
            case Answer() if robot == said.epoch.robot and self._reporter is not None:
                self._reporter.hear(said, number, now_s)
                if said.out and said.life == self._life and self.state is State.BOUND:
                    self._happen(Happening.LEFT_OUT)
                    return [Note(ViewLeft(epoch=said.epoch.number))]
            case Formation() if robot == said.epoch.robot and said.life == self._life:
                self._assembly.add(said)
                if self._reporter is not None:
                    self._reporter.heard_coordinator(now_s)
            case _:
                pass  # from nobody who may say so
        return []

    def _hear_plea(self, robot: int, plea: Plea, now_s: float) -> list[Command]:
        member = self.member
        if member is None or not member.leads:
            return []
        early = now_s < self._not_before_s.get(robot, 0.0) or robot in self.suspicion.suppressed(now_s)
        if self._plea is None and not early and not member.leaves_dead_end:
            self._plea = (robot, now_s)
        return [Say(robot, Answer(epoch=plea.epoch, life=plea.life, heard=0, out=True))]

    # --- acting -------------------------------------------------------------------------------------

    def act(self, now_s: float) -> list[Command]:
        """What is to be done now."""
        if self.state is State.BOUND and self._fence.may is May.ALL:
            self._take_place(now_s)
        commands = self._do(now_s)
        if self.coordinator is not None:
            commands = self._deliver(commands, now_s)
            commands += self._deliver(self.coordinator.act(self._driver.odometry, now_s), now_s)
        return commands + self._propose(now_s)

    def _take_place(self, now_s: float) -> None:
        whole = self._assembly.whole
        if whole is None or whole[0].turn != self._fence.turn or not in_force(self._fence):
            return
        self._happen(Happening.FORMED)
        formation, path = whole
        self._memory.adopt(formation)
        self._driver.begin(formation.s_m, self._bearing)
        self.member = Member(
            self._robot, self._life, self._mission, self._driver, self._senses, self._memory,
            formation, path, now_s,
        )  # fmt: skip

    @property
    def _bearing(self) -> Bearing:
        return Bearing(epoch=self._fence.epoch, turn=self._fence.turn, life=self._life)

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
                lost = self._fence.may is May.ALL and self._is_silent(3.0 * self._timing.plea_s, now_s)
                return self._report(now_s) + (self._plead(now_s) if lost else [])

    def _report(self, now_s: float) -> list[Command]:
        driver = self._driver
        driver.stand()
        stands = driver.standing and driver.odometry.ordered >= self._first_order
        if self._reporter is None or not stands:
            return []
        return self._reporter.act(driver, self._senses, now_s)

    def _join(self, now_s: float) -> list[Command]:
        reporter, driver = self._reporter, self._driver
        assert reporter is not None, "nobody has a turn without a coordinator"
        join = None if reporter.answer is None else reporter.answer.join
        is_over = reporter.ended is not None and reporter.ended.turn == self._fence.turn
        if is_over or join is None or join.turn != self._fence.turn:
            return self._report(now_s)
        if self._taker is None:
            driver.begin(0.0, self._bearing)
            pose = driver.odometry.pose
            start = np.array([pose.x_m, pose.y_m])
            epoch = self._fence.epoch.number
            self._joining = self._joining or Joining(self._mission, start, epoch=epoch)
            self._taker = TurnTaker(self._mission, driver, self._senses, self._joining, join, epoch)
        commands = self._taker.act(now_s)
        if self._taker.ended is None:
            return commands
        reporter.end_turn(self._taker.ended, moved=self._taker.has_moved)
        self._taker = None
        return commands + self._report(now_s)

    def _plead(self, now_s: float) -> list[Command]:
        """Ask the leader that odometry names to be let in."""
        self._driver.stand()
        fence, first_s = self._fence, 0.0 if self._since_s is None else self._since_s
        early = self._again and now_s - first_s < self._timing.first_plea_s
        if fence.may is not May.ALL or early or fence.robot == self._robot:
            return []
        if not is_due(last_s=self._pleaded_s, every_s=self._timing.plea_s, now_s=now_s):
            return []
        self._pleaded_s = now_s
        return [Say(fence.robot, Plea(epoch=fence.epoch, life=self._life))]

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

    _own_number = 0

    # --- proposing ----------------------------------------------------------------------------------

    def _propose(self, now_s: float) -> list[Command]:
        reason = self._reason(now_s)
        before = self._raising.proposed
        commands = self._raising.want(reason, self._fence, now_s)
        if reason is None or self._raising.proposed == before:
            return commands
        return [*commands, *self._note_why(reason, now_s)]

    def _note_why(self, reason: Reason, now_s: float) -> list[Command]:
        """What goes with a proposal, once."""
        self._ended_strand = None
        member = self.member
        if member is None:
            return []
        epoch = member.formation.epoch.number
        wish = member.wish
        match reason.cause:
            case Cause.DEAD_END if wish is not None and wish.turnabout is not None:
                turn = wish.turnabout
                self._ended_strand = turn, member.path
                return [
                    Note(
                        StrandReversed(
                            epoch=epoch, cut_m=turn.cut_m, end_m=turn.end_m, back_by_m=turn.back_by_m
                        )
                    )
                ]
            case Cause.BLOCKED:
                return [Note(StrandDissolved(epoch=epoch, blocked=reason.about or self._robot))]
            case Cause.NEIGHBOUR_LOST if reason.about is not None:
                link = next(link for link in member.links if link.neighbour == reason.about)
                if reason.why == "silence" and all(
                    other is link or not other.silent for other in member.links
                ):
                    self.suspicion.blame(link.neighbour, now_s)
                return [
                    Note(
                        LinkBroken(neighbour=link.neighbour, cause=reason.why, silent_s=link.silent_s(now_s))
                    )
                ]
            case Cause.PLEA if reason.about is not None:
                robot, timing = reason.about, self._timing
                wait_s = timing.plea_again_s * 2.0 ** self._let_in[robot]
                self._not_before_s[robot] = now_s + min(wait_s, timing.plea_again_s_max)
                self._let_in[robot] += 1
            case _:
                pass
        return []

    _ended_strand = None

    def _reason(self, now_s: float) -> Reason | None:
        """Why this robot wants a view now; None: it does not."""
        fence = self._fence
        if fence.epoch.robot == 0:
            first = fence.epoch.generation == 0
            cause = Cause.START if first else Cause.COORDINATOR_LOST
            return Reason(cause, "nobody coordinates")
        if self.member is not None:
            return self._member_reason(self.member, now_s)
        if fence.may is May.ALL:
            return self._outsider_reason(now_s)
        return self._bound_reason(now_s)

    def _member_reason(self, member: Member, now_s: float) -> Reason | None:
        wish = member.wish
        if wish is not None:
            return Reason(wish.cause, wish.why, wish.about)
        for link in member.links:
            why = self.suspicion.why_lost(link, now_s)
            if why is not None:
                return Reason(Cause.NEIGHBOUR_LOST, why, link.neighbour)
        if self._plea is not None:
            robot, at_s = self._plea
            if self._driver.standing or now_s - at_s > STOP_S:
                return Reason(Cause.PLEA, f"robot {robot} asks to be let in", robot)
        return None

    def _bound_reason(self, now_s: float) -> Reason | None:
        """Whether the coordinator is lost: gone, silent, or it does nothing."""
        coordinator, odometry, timing = self._fence.epoch.robot, self._driver.odometry, self._timing
        reporter = self._reporter
        assert reporter is not None, "a coordinator is reported to"
        if coordinator == self._robot and self.coordinator is not None:
            return None
        heard_s = max(reporter.heard_at_s, self._turned_s)
        stood = odometry.stood_s >= timing.stood_s and now_s - self._turned_s > timing.stood_s
        if self.suspicion.has_gone(coordinator, heard_s, now_s):
            why = "its token has gone"
        elif self.suspicion.judges(now_s) and now_s - heard_s > timing.coordinator_s:
            why = "it is silent"
        elif stood:
            why = "nobody has moved, and there was no turn"
        elif now_s - self._entered_s > timing.view_s:
            why = "the view takes too long"
        else:
            return None
        return Reason(Cause.COORDINATOR_LOST, why, coordinator)

    def _outsider_reason(self, now_s: float) -> Reason | None:
        if not self._is_silent(self._timing.outsider_s, now_s) or not self.suspicion.judges(now_s):
            return None
        if self._driver.odometry.stood_s >= self._timing.stood_s:
            return Reason(Cause.COORDINATOR_LOST, "the leader does not answer, and nobody moves")
        return Reason(Cause.OUTSIDERS, "the leader does not answer", outsider=True)

    def _is_silent(self, for_s: float, now_s: float) -> bool:
        """Whether neither coordinator nor leader has answered for so long."""
        heard_s = 0.0 if self._reporter is None else self._reporter.heard_at_s
        return now_s - max(heard_s, self._leader_heard_s) > for_s
