"""A robot's place in the strand: its two links, the path, and what it tells its neighbours.

Rule 1: the path begins where the tail stood when the strand formed, and leads over all places to the
        leader's; so all robots measure the same arc length.
Rule 2: a robot drives only while each of its links is fresh (`protocol.wire.link`). This is checked before
        anything else whenever the robot is entered, so that one that was frozen finds out first.
Rule 3: what is granted (`agents.strand.grants`), and all else that is news, is sent at once, and on every
        heartbeat.
Rule 4: the strand turns round as a whole (`Reversal`). The leader decides; each robot says so to the one
        behind only when the one ahead has, and it stands itself and knows all of the path. So when the tail
        has heard it, all stand. The tail opens the next epoch, as its first robot, and each takes its new
        place when it first hears the robot that is now ahead of it.
Rule 5: the strand dissolves as a whole in the same way (`Dissolution`); then all line up (`agents.robot`).
Rule 6: what the leader hands on goes from each robot to the one behind, until that has acknowledged it.
Rule 7: a neighbour whose link is silent for much of the time, though never for long, keeps the strand
        waiting, if this robot's other link is not.
"""

from dataclasses import dataclass

from agents.commands import Command, Note, Tell
from agents.due import is_due
from agents.events import LinkHeard
from agents.strand.grants import Grants
from agents.strand.growth import Growth
from protocol.arrays import Floats
from protocol.frames import Pose
from protocol.mission import Mission
from protocol.path import THERE_M, Path
from protocol.timeline import LinkHeard as LinkHeardAgain
from protocol.timeline import LinkSilent
from protocol.wire.link import Link
from protocol.wire.messages import AheadState, BehindState, Dissolution, Handover, Reversal

COMES_BACK_S = 15.0  # who is left out, and stands in the way; who has gone for so long does not

TOLD_VERTICES_MAX = 256  # a message's share of a long path; the rest follows when this has been acknowledged
SILENT_SHARE_MAX = 0.35  # of the time: no one silence that a link gets over comes to more than 0.33
STANDS_OUT = 4.0  # times as silent as the other link
URGENT_S = 0.1  # an odometry: so often a robot speaks while a link is not fresh enough to last


@dataclass(slots=True)
class Own:
    """What a robot tells its neighbours of itself."""

    progress_m: float
    pose: Pose
    stands: bool
    arrived: bool
    handed: Handover
    """The newest handover that it has."""
    blocked: int | None = None
    """Which robot's way is blocked: its own, or that of one behind it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """Where a robot and its neighbours stand when an epoch begins, in its arc length."""

    own_m: float
    ahead_m: float
    """Its own, where nobody is ahead."""
    behind_m: float
    """0, where nobody is behind."""


class Strand:
    """One robot's view of the strand, in one epoch."""

    def __init__(
        self,
        robot: int,
        order: tuple[int, ...],
        path: Path,
        at: Places,
        *,
        mission: Mission,
        now_s: float,
        epoch: int = 1,
        back_by_m: float = 0.0,
    ) -> None:
        self._mission = mission
        self.robot = robot
        self.order = order
        self.epoch = epoch
        self.back_by_m = back_by_m
        """How far the tail wants to come back along the path, before the other end leads again; or 0."""
        rank = order.index(robot)
        self._lineage = tuple(reversed(order[:rank]))
        self.start_m = at.own_m
        self.path = path
        self.laid_m = path.end_m
        """What of the path there was when the epoch began."""
        self._known_by_all = len(path)
        self.ahead: Link[AheadState] | None = Link(order[rank - 1], now_s) if rank > 0 else None
        self.behind: Link[BehindState] | None = Link(order[rank + 1], now_s) if order[rank + 1 :] else None
        self.links: tuple[Link[AheadState] | Link[BehindState], ...] = tuple(
            link for link in (self.ahead, self.behind) if link is not None
        )
        """The links that there are."""
        self.ahead_start_m = at.ahead_m
        """Where the robot ahead stood when the epoch began: short of that nobody of the strand stands."""
        self.own_leg_m = at.ahead_m
        """Up to here, where the robot ahead stood at first, nobody has driven and no leader certified."""
        self.grants = Grants(
            self.behind,
            path,
            mission,
            epoch=epoch,
            own_start_m=at.own_m,
            behind_start_m=at.behind_m,
        )
        self.growth = Growth(path, mission)
        self.authority_m = at.own_m if self.ahead is not None else self.laid_m
        self.reversal: Reversal | None = None
        self.dissolution: Dissolution | None = None
        """Either is set when this robot and all ahead of it stand until there is another strand."""
        self._told_at_s = -float("inf")
        self._told: tuple[object, ...] = ()
        self._moved_s = now_s

    def reverse(self, reversal: Reversal) -> None:
        """Rule 4, for the robot that leads: have the strand turn round. It stands, and stays."""
        self.reversal = reversal

    def pass_on_reversal(self) -> None:
        """Rule 4, for a robot that stands."""
        state = None if self.ahead is None else self.ahead.state
        if state is None or state.reversal is None:
            return
        if len(self.path) >= state.vertices and self.path.end_m >= state.reversal.end_m - THERE_M:
            self.reversal = state.reversal

    @property
    def dissolves_ahead(self) -> Dissolution | None:
        """Rule 5: what the robot ahead waits for, standing, with all that are ahead of it."""
        return None if self.ahead is None or self.ahead.state is None else self.ahead.state.dissolution

    @property
    def halted(self) -> bool:
        """Rules 4 and 5: whether this robot stands until there is another strand."""
        return self.reversal is not None or self.dissolution is not None

    @property
    def blocked_behind(self) -> int | None:
        """Which of the robots behind has said that its way is blocked."""
        return None if self.behind is None or self.behind.state is None else self.behind.state.blocked

    def turned_round(self, own_m: float, now_s: float, first: AheadState | None) -> "Strand":
        """The strand of the next epoch, as this robot sees it that stands at `own_m`.

        `first` is what its new robot ahead told first; None for the one that leads.
        """
        assert self.reversal is not None, "a strand turns round when all have been told"
        end_m = self.reversal.end_m
        behind_m = end_m if self.ahead is None or self.ahead.state is None else self.ahead.state.progress_m
        at = Places(
            own_m=end_m - own_m,
            ahead_m=end_m - own_m if first is None else first.progress_m,
            behind_m=end_m - behind_m,
        )
        turned = Strand(
            self.robot,
            tuple(reversed(self.order)),
            self.path.reversed(self.reversal.cut_m, end_m),
            at,
            mission=self._mission,
            now_s=now_s,
            epoch=self.epoch + 1,
            back_by_m=self.reversal.back_by_m,
        )
        turned.own_leg_m = at.own_m  # the one ahead has driven all of the path, or certified its leg to here
        return turned

    def robots_beside(self) -> list[Floats]:
        """Ground (n, 2) that the robots ahead and behind may be on, each as last heard."""
        grounds = [self.grants.ground.behind] if self.behind is not None else []
        if self.ahead is not None and self.ahead.state is not None:
            from_m = self.ahead.state.progress_m
            grounds.append(self.path.between(from_m, from_m + self.grants.way_m))
        return grounds

    def quiet_s(self, now_s: float) -> float:
        """How long all robots behind have stood, as far as is known [s]. The tail moves last of all."""
        return now_s - self._moved_s

    @property
    def silent(self) -> bool:
        """Whether a link is not fresh, or never has been."""
        return any(link.silent or not link.established for link in self.links)

    @property
    def handed(self) -> Handover | None:
        """What the robot ahead has handed on, if it just has."""
        return None if self.ahead is None or self.ahead.state is None else self.ahead.state.handed

    @property
    def _all_stand_behind(self) -> bool:
        return self.behind is None or (self.behind.state is not None and self.behind.state.stand)

    def watch(self, now_s: float) -> list[Command]:
        """Rule 2: note which links have fallen silent."""
        commands: list[Command] = []
        for link in self.links:
            link.note(now_s, silence_s=self._mission.silence_s)
            if not link.silent and link.silent_s(now_s) > self._mission.silence_s:
                link.silent = True
                commands.append(Note(LinkSilent(neighbour=link.neighbour, silent_s=link.silent_s(now_s))))
        return commands

    def stands_out(self, link: Link[AheadState] | Link[BehindState]) -> bool:
        """Whether the other link, if any, is silent for so much less that it is not this robot's doing."""
        others = [other for other in self.links if other is not link]
        return all(STANDS_OUT * other.silent_share < link.silent_share for other in others)

    def keeps_waiting(self, link: Link[AheadState] | Link[BehindState]) -> bool:
        """Rule 7. Where all links are alike, as where all messages may be lost, there is nothing to gain."""
        return len(self.links) > 1 and link.silent_share > SILENT_SHARE_MAX and self.stands_out(link)

    def hear(self, heard: LinkHeard, now_s: float) -> list[Command]:
        """Take in a neighbour's state; one of another epoch, or of nobody beside us, is void."""
        for link in self.links:
            if link.neighbour == heard.robot and heard.state.epoch == self.epoch:
                return self._hear(link, heard, now_s)
        return []

    def _hear(
        self, link: Link[AheadState] | Link[BehindState], heard: LinkHeard, now_s: float
    ) -> list[Command]:
        match heard.state:
            case AheadState() as state if link is self.ahead:
                newer = self.ahead.hear(state, heard.number, now_s)
                self.path.learn(state.path_from, state.path)
                self.authority_m = max(self.authority_m, state.authority_m)
            case BehindState() as state if link is self.behind:
                tail_m = self.grants.tail_m
                newer = self.behind.hear(state, heard.number, now_s)
                if self.grants.tail_m != tail_m or not state.stand:
                    self._moved_s = now_s
            case _:
                return []
        if not (newer and link.silent and link.silent_s(now_s) <= self._mission.silence_s):
            return []
        link.silent = False
        return [Note(LinkHeardAgain(neighbour=link.neighbour))]

    def tell(self, own: Own, now_s: float) -> list[Command]:
        """Rule 3: grant what has become free; tell both neighbours if there is news or a heartbeat due."""
        commands = self.grants.grant(self.growth, progress_m=own.progress_m, arrived=own.arrived)
        news = (
            self.grants.granted_m,
            len(self.path),
            own.arrived,
            own.blocked,
            own.handed.number,
            self.reversal,
            self.dissolution,
        )
        if news == self._told and not is_due(
            last_s=self._told_at_s, every_s=self._tell_s(now_s), now_s=now_s
        ):
            return commands
        self._told, self._told_at_s = news, now_s
        if self.behind is not None:
            commands.append(Tell(self.behind.neighbour, self._ahead_state(self.behind, own, now_s)))
        if self.ahead is not None:
            commands.append(Tell(self.ahead.neighbour, self._behind_state(self.ahead, own, now_s)))
        return commands

    def _tell_s(self, now_s: float) -> float:
        """How often to speak: there and back again takes a fresh link two heartbeats and a little."""
        oldest_s = max((link.silent_s(now_s) for link in self.links), default=0.0)
        settled = all(link.established for link in self.links) and oldest_s <= 2.5 * self._mission.heartbeat_s
        return self._mission.heartbeat_s if settled else URGENT_S

    def _ahead_state(self, behind: Link[BehindState], own: Own, now_s: float) -> AheadState:
        # The last that is known is told again: it may have moved on.
        path_from = max((behind.state.vertices if behind.state else self._known_by_all) - 1, 0)
        has = behind.state.handed if behind.state is not None else own.handed.number
        return AheadState(
            epoch=self.epoch,
            t_s=now_s,
            echo_s=behind.said_s,
            path_from=path_from,
            path=self.path.told_from(path_from, TOLD_VERTICES_MAX),
            progress_m=own.progress_m,
            authority_m=self.grants.granted_m,
            pose=own.pose,
            arrived=own.arrived,
            lineage=self._lineage,
            vertices=len(self.path),
            backs_up=self.back_by_m > 0.0,
            reversal=self.reversal,
            dissolution=self.dissolution,
            handed=own.handed if has < own.handed.number and not self.halted else None,  # one map has room
        )

    def _behind_state(self, ahead: Link[AheadState], own: Own, now_s: float) -> BehindState:
        return BehindState(
            epoch=self.epoch,
            t_s=now_s,
            echo_s=ahead.said_s,
            handed=own.handed.number,
            vertices=len(self.path),
            progress_m=own.progress_m,
            tail_progress_m=min(self.grants.tail_m if self.behind else own.progress_m, own.progress_m),
            stand=own.stands and self._all_stand_behind,
            pose=own.pose,
            blocked=own.blocked,
        )
