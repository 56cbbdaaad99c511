"""A robot's place in the strand: its two links, the path, and what it grants the robot behind.

Rule 1: the path begins where the tail stood when the strand formed, and leads over all places to the
        leader's; so all robots measure the same arc length.
Rule 2: a robot drives only while it has heard each of its links within `silence_s`. This is checked before
        anything else whenever the robot is entered, so that one that was frozen finds out first.
Rule 3: what is granted only grows; it is sent when it has grown enough to matter, and on every heartbeat.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from agents.commands import Command, Note, Tell
from agents.events import LinkHeard
from agents.ground import Ground
from protocol.authority import authority_m, claim_m
from protocol.frames import Point, Pose
from protocol.link import Link
from protocol.messages import AheadState, BehindState
from protocol.mission import Mission
from protocol.path import Path, straightened
from protocol.timeline import AuthorityGranted, LinkSilent
from protocol.timeline import LinkHeard as LinkHeardAgain

TOLD_VERTICES_MAX = 256  # a message's share of a long path; the rest follows when this has been acknowledged
GRANT_M_MIN = 0.05  # a grant worth a message: a tenth of a second at 0.5 m/s


@dataclass(slots=True)
class Own:
    """What a robot tells its neighbours of itself."""

    progress_m: float
    pose: Pose
    arrived: bool


class Strand:
    """One robot's view of the strand, in one epoch."""

    def __init__(
        self, robot: int, order: tuple[int, ...], places: Mapping[int, Pose], mission: Mission, now_s: float
    ) -> None:
        self._mission = mission
        self.epoch = 1
        rank = order.index(robot)
        self._lineage = tuple(reversed(order[:rank]))
        starts = [Point(x_m=places[k].x_m, y_m=places[k].y_m) for k in reversed(order)]
        start_m = {robot: vertex.s_m for robot, vertex in zip(reversed(order), Path(starts), strict=True)}
        self.start_m = start_m[robot]
        self.path = Path(straightened(starts))  # a straight queue is one segment: one check, no stops
        self._known_by_all = len(self.path)
        self.ahead: Link[AheadState] | None = Link(order[rank - 1], now_s) if rank > 0 else None
        last = rank == len(order) - 1
        self.behind: Link[BehindState] | None = None if last else Link(order[rank + 1], now_s)
        self.ahead_start_m = start_m[order[rank - 1]] if rank > 0 else self.start_m
        """Where the robot ahead stood at first: this robot's own leg, which nobody has driven, ends there."""
        # Each robot may be where it stands; so that much is granted before anything is said.
        self.behind_start_m = 0.0 if last else start_m[order[rank + 1]]
        self.granted_m = self.behind_start_m
        self.authority_m = self.start_m
        self._told_at_s = -float("inf")
        self._told: tuple[object, ...] = ()
        self._taken: tuple[object, ...] = ()

    @property
    def keep_m(self) -> float:
        """Least distance between the centres of two robots that ground is granted for; 0: nobody is behind.

        The tolerance on top is what two robots may be off their path.
        """
        if self.behind is None:
            return 0.0
        return 2.0 * self._mission.robot_radius_m + self._mission.separation_m + self._mission.mu0_m

    @property
    def tail_m(self) -> float:
        """Arc length behind which there is nobody, as far as is known."""
        if self.behind is None:
            return self.start_m
        return self.behind.state.tail_progress_m if self.behind.state else 0.0

    def claim_m(self, to_m: float, *, progress_m: float) -> float:
        """How much of the way to an arc length keeps off the robots behind."""
        if self.behind is None:
            return to_m
        return claim_m(
            self.path,
            progress_m=progress_m,
            to_m=to_m,
            tail_m=self.tail_m,
            granted_m=self.granted_m,
            keep_m=self.keep_m,
        )

    @property
    def ground(self) -> Ground:
        """What the robots behind take up."""
        return Ground(
            self.path,
            self.tail_m,
            self.granted_m,
            self.keep_m,
            self._behind_m,
            min(self.granted_m, self._behind_m + self._way_m),
        )

    @property
    def _behind_m(self) -> float:
        """Where the robot behind was, when it was last heard."""
        if self.behind is None or self.behind.state is None:
            return self.behind_start_m
        return self.behind.state.progress_m

    @property
    def _way_m(self) -> float:
        """How far a robot that has just been heard may have come since: two heartbeats' way."""
        return 2.0 * self._mission.heartbeat_s * self._mission.speed_mps

    @property
    def stretch_m(self) -> float:
        """How far the robot behind is short of what it has been granted."""
        if self.behind is None or self.behind.state is None:
            return 0.0  # nobody lags who has not been heard
        return max(0.0, self.granted_m - self._behind_m)

    @property
    def silent(self) -> bool:
        """Whether a link has not been heard for too long, or not at all yet."""
        return any(link is not None and (link.silent or link.state is None) for link in self._links)

    @property
    def _links(self) -> tuple[Link[AheadState] | None, Link[BehindState] | None]:
        return self.ahead, self.behind

    def watch(self, now_s: float) -> list[Command]:
        """Rule 2: note which links have fallen silent."""
        commands: list[Command] = []
        for link in self._links:
            if link is not None and not link.silent and link.silent_s(now_s) > self._mission.silence_s:
                link.silent = True
                commands.append(Note(LinkSilent(neighbour=link.neighbour, silent_s=link.silent_s(now_s))))
        return commands

    def hear(self, heard: LinkHeard, now_s: float) -> list[Command]:
        """Take in a neighbour's state; one of another epoch, or of nobody beside us, is void."""
        for link in self._links:
            if link is not None and link.neighbour == heard.robot and heard.state.epoch == self.epoch:
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
                newer = self.behind.hear(state, heard.number, now_s)
            case _:
                return []
        if not (newer and link.silent):
            return []
        link.silent = False
        return [Note(LinkHeardAgain(neighbour=link.neighbour))]

    def tell(self, own: Own, now_s: float) -> list[Command]:
        """Rule 3: grant what has become free; tell both neighbours if there is news or a heartbeat due."""
        commands = self._grant(own)
        news = (self.granted_m, len(self.path), own.arrived)
        if news == self._told and now_s - self._told_at_s < self._mission.heartbeat_s:
            return commands
        self._told, self._told_at_s = news, now_s
        if self.behind is not None:
            commands.append(Tell(self.behind.neighbour, self._ahead_state(self.behind, own)))
        if self.ahead is not None:
            commands.append(Tell(self.ahead.neighbour, self._behind_state(own)))
        return commands

    def _grant(self, own: Own) -> list[Command]:
        if self.behind is None:
            return []
        taken = (self.granted_m, own.progress_m, len(self.path), own.arrived)
        if taken == self._taken:
            return []  # nothing has moved, so nothing has become free
        self._taken = taken
        free_m = authority_m(
            self.path, from_m=max(self.tail_m, self.granted_m), progress_m=own.progress_m, keep_m=self.keep_m
        )
        enough_m = 0.0 if own.arrived else GRANT_M_MIN
        if free_m <= self.granted_m + enough_m:
            return []
        self.granted_m = free_m
        grant = AuthorityGranted(to=self.behind.neighbour, epoch=self.epoch, authority_m=free_m)
        return [Note(grant)]

    def _ahead_state(self, behind: Link[BehindState], own: Own) -> AheadState:
        path_from = behind.state.vertices if behind.state else self._known_by_all
        return AheadState(
            epoch=self.epoch,
            path_from=path_from,
            path=self.path.told_from(path_from, TOLD_VERTICES_MAX),
            progress_m=own.progress_m,
            authority_m=self.granted_m,
            pose=own.pose,
            arrived=own.arrived,
            lineage=self._lineage,
        )

    def _behind_state(self, own: Own) -> BehindState:
        return BehindState(
            epoch=self.epoch,
            vertices=len(self.path),
            progress_m=own.progress_m,
            tail_progress_m=min(self.tail_m if self.behind else own.progress_m, own.progress_m),
            pose=own.pose,
        )
