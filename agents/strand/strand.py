"""A robot's place in the strand: its two links, the path, and what it tells its neighbours.

Rule 1 (safety): places, path and arc lengths are those of the formation, as told. Nothing is taken from a
        state of another epoch, of another life than the formation names, or from a robot that is no
        neighbour (F5 of docs/strand.md); nor from one that cannot be true (`agents.strand.plausible`).
Rule 2 (safety): hits of a scan are robots only where a neighbour may be: the one behind between where it was
        last heard and what it has been granted, the one ahead from where it was last heard on. Before a
        neighbour is first heard, its place in the formation counts (F6).
Rule 3 (liveness): what is granted (`agents.strand.grants`), and all other news, is sent at once, several
        times, and then on every heartbeat. A silent link stops no robot: it may use up its authority.
Rule 4: the leader's handover goes from each robot to the one behind until that has acknowledged it.
"""

import math

from agents.commands import Command, Note
from agents.events import LinkHeard
from agents.strand.grants import Grants
from agents.strand.growth import Growth
from agents.strand.news import News, Own
from agents.strand.plausible import WRONG_SIDE, refused, wrong_ahead, wrong_behind
from protocol.arrays import Floats, xy
from protocol.fence import Epoch
from protocol.frames import Point
from protocol.mission import Mission
from protocol.path import Path
from protocol.timeline import LinkHeard as LinkHeardAgain
from protocol.timeline import LinkSilent
from protocol.wire.link import Link
from protocol.wire.messages import AheadState, BehindState
from protocol.wire.view import Counters, Formation


class Strand:
    """One robot's view of the strand, in one epoch."""

    def __init__(
        self,
        robot: int,
        formation: Formation,
        path: Path,
        mission: Mission,
        now_s: float,
    ) -> None:
        self._mission = mission
        self._formation = formation
        self.robot = robot
        self.path = path
        self.laid_m = path.end_m
        """Length of the path when the epoch began."""
        self._back_by_m = formation.back_by_m
        self.ahead: Link[AheadState] | None = None
        self.behind: Link[BehindState] | None = None
        if (ahead := formation.ahead) is not None:
            self.ahead = Link(ahead.robot, ahead.life, formation.epoch, now_s)
        if (behind := formation.behind) is not None:
            self.behind = Link(behind.robot, behind.life, formation.epoch, now_s)
        self.links: tuple[Link[AheadState] | Link[BehindState], ...] = tuple(
            link for link in (self.ahead, self.behind) if link is not None
        )
        """The links that there are."""
        self.linked = frozenset(link.neighbour for link in self.links)
        """The robots at their other ends."""
        ahead_m = formation.s_m if formation.ahead is None else formation.ahead.s_m
        self._ahead_start_m = ahead_m
        self.own_leg_m = formation.s_m if formation.leg_is_driven else ahead_m
        """Up to here no robot has driven the path and no leader has certified it."""
        self.grants = Grants(
            self.behind,
            path,
            mission,
            epoch=self.number,
            own_start_m=formation.s_m,
            behind_start_m=0.0 if formation.behind is None else formation.behind.s_m,
        )
        self.growth = Growth(path, mission)
        self.authority_m = self.laid_m if self.ahead is None else formation.s_m
        self._news = News(formation, path, mission, self.grants, ahead=self.ahead, behind=self.behind)
        self._moved_s = now_s
        self._watched_s: float | None = None
        """When the links were looked at last; None: a state has been heard since."""

    @property
    def epoch(self) -> Epoch:
        """The strand's epoch."""
        return self._formation.epoch

    @property
    def number(self) -> int:
        """The same as in the timeline."""
        return self.epoch.number

    @property
    def members(self) -> int:
        """How many robots are in the strand."""
        return self._formation.members

    @property
    def start_m(self) -> float:
        """The robot's place in the formation."""
        return self._formation.s_m

    @property
    def back_by_m(self) -> float:
        """How far the tail wants to come back along the path before the other end leads again; 0: not."""
        return self._back_by_m

    def lead_on(self) -> None:
        """The first robot stays the leader: the tail need not come back any further."""
        self._back_by_m = 0.0

    @property
    def tries_leaders(self) -> bool:
        """Whether it was formed since a leader knew no way on, and has not advanced since."""
        return len(self._formation.counters.last_to_lead) > 0

    @property
    def counters(self) -> Counters:
        """The counts of the formation; where the strand has advanced, those of attempts in vain begin anew.

        It has where steps towards the goal have led its leader further off than robots keep: locked in, a
        leader still creeps by centimetres, and goes to and fro between two gaps that are a little too narrow.
        """
        counters, path = self._formation.counters, self.path
        anew = Counters(steps=counters.steps, heals=counters.heals)
        if counters == anew:
            return counters  # as in most strands: there were no attempts in vain
        advanced_m = math.dist(xy(path.at(self.laid_m)), xy(path.at(path.end_m)))
        has_advanced = advanced_m > self._mission.robot_keep_m and not self.back_by_m > 0.0
        return anew if has_advanced else counters

    # --- where the neighbours are -------------------------------------------------------------------

    @property
    def _ahead_m(self) -> float:
        """Where the robot ahead was last heard."""
        state = None if self.ahead is None else self.ahead.state
        return self._ahead_start_m if state is None else state.progress_m

    @property
    def behind_m(self) -> float | None:
        """Where the robot behind was last heard; None: there is none."""
        return None if self.behind is None or self.grants.withheld else self.grants.behind_m

    @property
    def neighbours(self) -> dict[int, Point]:
        """Where the neighbours were last heard."""
        at_m = [(self.ahead, self._ahead_m), (self.behind, self.grants.behind_m)]
        return {link.neighbour: self.path.at(s_m) for link, s_m in at_m if link is not None}

    @property
    def robots_in_sight(self) -> list[Floats]:
        """Ground (n, 2) on which hits are robots of the strand (rule 2)."""
        grounds = [self.grants.ground.behind] if self.behind is not None else []
        if self.ahead is not None:
            grounds.append(self.path.between(self._ahead_m, self.path.end_m))
        return grounds

    @property
    def quiet_s(self) -> float:
        """How long all robots behind had stood when they were last heard [s]. The tail moves last of all."""
        if self.behind is None:
            return float("inf")
        return max(0.0, self.behind.heard_at_s - self._moved_s)

    # --- hearing ------------------------------------------------------------------------------------

    def watch(self, now_s: float) -> list[Command]:
        """Note which links have fallen silent, and which are heard again."""
        commands: list[Command] = []
        if now_s == self._watched_s:
            return commands  # nothing can be new
        self._watched_s = now_s
        silence_s = self._mission.silence_s
        for link in self.links:
            if not link.note(now_s, silence_s=silence_s):
                continue
            neighbour = link.neighbour
            silent = LinkSilent(neighbour=neighbour, silent_s=link.silent_s(now_s)) if link.silent else None
            commands.append(Note(silent or LinkHeardAgain(neighbour=neighbour)))
        return commands

    def hear(self, heard: LinkHeard, now_s: float) -> list[Command]:
        """Take in a neighbour's state (rule 1)."""
        for link in self.links:
            if link.is_from(heard.robot, heard.state) and link.is_newer(heard.number):
                self._watched_s = None
                reason = self._take_in(link, heard, now_s)
                return [] if reason is None else [Note(refused(heard.robot, self.robot, reason))]
        return []

    def _take_in(
        self, link: Link[AheadState] | Link[BehindState], heard: LinkHeard, now_s: float
    ) -> str | None:
        """Returns why the state is refused, if it is."""
        match heard.state:
            case AheadState() as state if self.ahead is not None and link is self.ahead:
                if (reason := wrong_ahead(state, self.path)) is not None:
                    return reason
                self.ahead.hear(state, heard.number, now_s)
                self.path.learn(state.path_from, state.path)
                self.authority_m = max(self.authority_m, state.authority_m)
                if not state.backs_up:
                    self.lead_on()
            case BehindState() as state if self.behind is not None and link is self.behind:
                grants = self.grants
                reason = wrong_behind(
                    state,
                    vertices=len(self.path),
                    start_m=grants.behind_start_m,
                    granted_m=grants.granted_m,
                )
                if reason is not None:
                    return reason
                tail_m = grants.tail_m
                self.behind.hear(state, heard.number, now_s)
                if grants.tail_m != tail_m or not state.stand:
                    self._moved_s = now_s
            case _:
                return WRONG_SIDE
        return None

    # --- telling ------------------------------------------------------------------------------------

    def tell(self, own: Own, now_s: float) -> list[Command]:
        """Rule 3: grant what has become free, and tell the neighbours."""
        granted = self.grants.grant(self.growth, progress_m=own.progress_m, arrived=own.arrived)
        return granted + self._news.tell(own, now_s, backs_up=self.back_by_m > 0.0)
