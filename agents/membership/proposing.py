"""Why a robot proposes a view. Liveness: whatever it proposes, bodies obey the fence.

Rule 1: where no robot coordinates, any robot proposes a view.
Rule 2: a bound robot proposes one when its coordinator is lost: its token has gone, it is silent, or it does
        nothing though nobody moves.
Rule 3: a member proposes one for its own reason (`Member.reason`), for a neighbour that is lost, and, if
        it leads, for a robot that asks to be let in. A leader without a way on lets such a robot in first: it
        may be what stands in the way.
Rule 4: a robot that is left out, and has no answer from the leader, proposes one as an outsider; where no
        body moves and the leader's token has gone, as any robot may. A strand that stands may have arrived.
        The robot that was to lead and has no formation sees no token of its own, so it is one of these.
"""

from collections.abc import Mapping
from dataclasses import replace

from agents.commands import Command, Note
from agents.coordinating.agreeing import Intent, Turning
from agents.liveness.raising import Raising
from agents.liveness.reason import Reason, Turnabout
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from agents.membership.pleas import Pleas
from agents.membership.reporting import Reporter
from agents.strand.member import Member
from protocol.fence import NOBODY_NUMBER, Cause, Fence, May
from protocol.frames import Point
from protocol.timeline import LinkBroken, StrandDissolved, StrandReversed
from protocol.wire.messages import Odometry


class Proposing:
    """The proposals of one robot."""

    def __init__(self, robot: int, life: int, timing: Timing, suspicion: Suspicion, pleas: Pleas) -> None:
        self._robot = robot
        self._life = life
        self._timing = self.timing = timing
        """`timing`: in this epoch."""
        self._suspicion = suspicion
        self._pleas = pleas
        self._raising = Raising(robot, life, timing)
        self._turn_s = 0.0
        """When odometry first told this turn."""
        self._led_by = 0
        self._leader_heard_s = 0.0

    def enter(self, fence: Fence, now_s: float) -> None:
        """Odometry tells a newer fence."""
        self._raising.enter(fence)
        self.timing = self._timing.slower(self._raising.in_vain(fence.epoch.generation) - 1)
        self._turn_s = now_s
        if fence.may is May.ALL:
            self._led_by, self._leader_heard_s = fence.robot, now_s

    def leader_answers(self, now_s: float) -> None:
        """The leader has answered a plea."""
        self._leader_heard_s = now_s

    def is_silent(self, reporter: Reporter, for_s: float, now_s: float) -> bool:
        """Whether neither coordinator nor leader has answered for so long."""
        return now_s - max(reporter.heard_at_s, self._leader_heard_s) > for_s

    def intent(self, member: Member | None, neighbours: Mapping[int, Point]) -> Intent:
        """What this robot has proposed the newest view for; to be asked before it leaves its strand."""
        proposed, reason = self._raising.reason, None if member is None else member.reason
        intent = Intent(Cause.START if proposed is None else proposed.cause, self._led_by, neighbours)
        if member is None or reason is None or reason.turnabout is None or reason.cause is not intent.cause:
            return intent
        return replace(intent, turning=Turning(reason.turnabout, member.formation, member.path))

    def act(
        self, odometry: Odometry, reporter: Reporter, member: Member | None, now_s: float
    ) -> list[Command]:
        """Propose a view if there is a reason to."""
        fence, reason = odometry.fence, None
        if fence.epoch.robot == NOBODY_NUMBER:
            cause = Cause.START if fence.epoch.generation == 0 else Cause.COORDINATOR_LOST
            reason = Reason(cause, "nobody coordinates")
        elif member is not None:
            reason = self._for_member(member, odometry, reporter, now_s)
        elif fence.may is May.ALL:
            reason = self._for_outsider(odometry, reporter, now_s)
        elif (fence.epoch.robot, fence.epoch.life) != (self._robot, self._life):  # another one coordinates
            reason = self._for_bound(odometry, reporter, now_s)
        commands = self._raising.want(reason, fence, now_s)
        if reason is None or member is None or not any(isinstance(each, Note) for each in commands):
            return commands
        return [*commands, *self._note(reason, member, now_s)]

    def _for_member(
        self, member: Member, odometry: Odometry, reporter: Reporter, now_s: float
    ) -> Reason | None:
        """Rule 3."""
        own, plea = member.reason, self._pleas.reason(now_s, stands=not odometry.moving)
        if own is not None and (plea is None or own.cause not in {Cause.DEAD_END, Cause.NO_WAY}):
            return own
        all_wait = odometry.stood_s > self._timing.stood_s and not member.arrived
        for link in member.strand.links:
            how = self._suspicion.why_lost(link, now_s, named_s=reporter.formed_s, all_wait=all_wait)
            if how is not None:
                return Reason(Cause.NEIGHBOUR_LOST, f"robot {link.neighbour} is lost", link.neighbour, how)
        return plea

    def _for_bound(self, odometry: Odometry, reporter: Reporter, now_s: float) -> Reason | None:
        """Rule 2."""
        coordinator = odometry.fence.epoch.robot
        heard_s = max(self._turn_s, reporter.heard_at_s)
        # Where own reports are lost there are no answers either; others that move show that the view goes on.
        idle_s = min(odometry.stood_s, now_s - self._turn_s)
        is_deaf = min(idle_s, now_s - reporter.heard_at_s) > self.timing.coordinator_s
        if self._suspicion.has_gone(coordinator, heard_s, now_s):
            why = f"robot {coordinator} coordinated, and its token has gone"
        elif is_deaf and self._suspicion.judges(now_s):
            why = f"robot {coordinator} coordinates, and is silent"
        elif idle_s > self._timing.stood_s:
            why = "nobody has moved, and there was no turn"
        else:
            return None
        return Reason(Cause.COORDINATOR_LOST, why, coordinator)

    def _for_outsider(self, odometry: Odometry, reporter: Reporter, now_s: float) -> Reason | None:
        """Rule 4."""
        silent = self.is_silent(reporter, self._timing.outsider_s, now_s)
        if not silent or not self._suspicion.judges(now_s):
            return None
        has_gone = self._suspicion.has_gone(self._led_by, self._leader_heard_s, now_s)
        if has_gone and odometry.stood_s >= self._timing.stood_s:
            return Reason(Cause.COORDINATOR_LOST, "the leader does not answer, and nobody moves")
        return Reason(Cause.OUTSIDERS, "the leader does not answer")

    def _note(self, reason: Reason, member: Member, now_s: float) -> list[Command]:
        """What goes with a member's proposal, once."""
        epoch = member.formation.epoch.number
        match reason:
            case Reason(Cause.DEAD_END, turnabout=Turnabout() as turn):
                turned = StrandReversed(
                    epoch=epoch, cut_m=turn.cut_m, end_m=turn.end_m, back_by_m=turn.back_by_m
                )
                return [Note(turned)]
            case Reason(Cause.BLOCKED, about=blocked):
                return [Note(StrandDissolved(epoch=epoch, blocked=blocked or self._robot))]
            case Reason(Cause.NEIGHBOUR_LOST, about=int(neighbour), how=how):
                link = next(link for link in member.strand.links if link.neighbour == neighbour)
                others = [other for other in member.strand.links if other is not link]
                if how == "silence" and not any(other.silent for other in others):
                    self._suspicion.blame(neighbour, now_s)
                silent_s = link.silent_s(now_s)
                return [Note(LinkBroken(neighbour=neighbour, cause=how, silent_s=silent_s))]
            case Reason(Cause.PLEA):
                self._pleas.let_in(self._pleas.asking, now_s)
            case _:
                pass
        return []
