"""What a robot tells its neighbours in the strand, and how often. Liveness: any one message is enough.

Rule 1: it tells its whole state at once when there is news, for a while after that, and while a neighbour is
        silent; else on every heartbeat.
"""

from typing import NamedTuple

from agents.commands import Command, Tell
from agents.due import is_due
from agents.strand.grants import GRANT_M_MIN, Grants
from protocol.mission import Mission
from protocol.path import Path
from protocol.wire.link import Link
from protocol.wire.messages import AheadState, BehindState, Handover
from protocol.wire.view import Formation

TOLD_VERTICES_MAX = 256  # a message's share of a long path; the rest follows when this has been acknowledged
URGENT_S = 0.1  # an odometry: so often a robot speaks while there is news, or while a neighbour is silent
NEWS_S = 0.5  # news for so long: six messages, of which one arrives in 98 % of cases at 50 % loss


class Own(NamedTuple):
    """What a robot tells its neighbours of itself."""

    progress_m: float
    stands: bool
    arrived: bool
    handed: Handover
    """The newest handover that it has."""


class News:
    """One robot's link states in one strand."""

    def __init__(
        self,
        formation: Formation,
        path: Path,
        mission: Mission,
        grants: Grants,
        *,
        ahead: Link[AheadState] | None,
        behind: Link[BehindState] | None,
    ) -> None:
        self._formation = formation
        self._path = path
        self._known_by_all = len(path)
        self._mission = mission
        self._grants = grants
        self._ahead = ahead
        self._behind = behind
        self._links = [link for link in (ahead, behind) if link is not None]
        self._told_at_s = self._news_at_s = -float("inf")
        self._told: tuple[object, ...] = ()

    def tell(self, own: Own, now_s: float, *, backs_up: bool) -> list[Command]:
        """Tell both neighbours, if there is news or a heartbeat due (rule 1)."""
        news = (
            self._grants.granted_m,
            len(self._path),
            round(own.progress_m / GRANT_M_MIN),
            own.arrived,
            own.handed.number,
            backs_up,
        )
        if news != self._told:
            self._news_at_s = now_s
        elif not is_due(last_s=self._told_at_s, every_s=self._tell_s(now_s), now_s=now_s):
            return []
        self._told, self._told_at_s = news, now_s
        commands: list[Command] = []
        if self._behind is not None:
            state = self._ahead_state(self._behind, own, now_s, backs_up=backs_up)
            commands.append(Tell(self._behind.neighbour, state))
        if self._ahead is not None:
            commands.append(Tell(self._ahead.neighbour, self._behind_state(own, now_s)))
        return commands

    def _tell_s(self, now_s: float) -> float:
        """How often to speak: a neighbour that is not heard may not hear this robot either."""
        heartbeat_s = self._mission.heartbeat_s
        if now_s - self._news_at_s < NEWS_S:
            return URGENT_S
        is_settled = all(link.silent_s(now_s) <= 2.5 * heartbeat_s for link in self._links)
        return heartbeat_s if is_settled else URGENT_S

    def _ahead_state(
        self, behind: Link[BehindState], own: Own, now_s: float, *, backs_up: bool
    ) -> AheadState:
        # The last that is known is told again: it may have moved on.
        path_from = max((behind.state.vertices if behind.state else self._known_by_all) - 1, 0)
        has = behind.state.handed if behind.state is not None else own.handed.number
        return AheadState(
            epoch=self._formation.epoch,
            life=self._formation.life,
            t_s=now_s,
            path_from=path_from,
            path=self._path.told_from(path_from, TOLD_VERTICES_MAX),
            progress_m=own.progress_m,
            authority_m=self._grants.granted_m,
            arrived=own.arrived,
            vertices=len(self._path),
            backs_up=backs_up,
            handed=own.handed if has < own.handed.number else None,
        )

    def _behind_state(self, own: Own, now_s: float) -> BehindState:
        behind = self._behind
        return BehindState(
            epoch=self._formation.epoch,
            life=self._formation.life,
            t_s=now_s,
            handed=own.handed.number,
            vertices=len(self._path),
            progress_m=own.progress_m,
            tail_progress_m=min(self._grants.tail_m if behind else own.progress_m, own.progress_m),
            stand=own.stands and (behind is None or (behind.state is not None and behind.state.stand)),
        )
