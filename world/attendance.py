"""The failure detector of the world: liveliness tokens and messages of robots [wall-clock seconds].

Rule 1: a robot is present from its first token on.
Rule 2: a robot has died when it shows no token and was silent for `SILENCE_S`, and for longer than the
        lateness of the machine may explain. So a token that the router loses for a moment is no death.
        The token must have been gone for `GONE_S`: when our own link is lost, tokens vanish one after the
        other, after a silence of all, and only then does it show that there is no router.
Rule 3: a robot that ended as told, when the run was over, has not died. A resumed world finds these robots in
        the timeline.
Rule 4: a dead robot that shows a token again is alive. With another incarnation it was restarted; with the
        same one it was frozen or cut off. A restarted robot has died before, even if undetected.
"""

import math
from collections.abc import Mapping, Set
from dataclasses import dataclass, field
from enum import Enum, auto

SILENCE_S = 1.0  # docs/processes.md
GONE_S = 0.2  # wall: 40 times what Zenoh takes to close a link on an idle machine


class Coming(Enum):
    """The meaning of a token that appears."""

    NEW = auto()
    RESTARTED = auto()
    RETURNED = auto()
    KNOWN = auto()  # it was never considered dead


@dataclass(slots=True)
class Attendance:
    """The robots that have come, that show a token, that have died."""

    robots: frozenset[int]
    come: set[int] = field(default_factory=set)
    dead: set[int] = field(default_factory=set)
    gone: frozenset[int] = frozenset()
    """Robots that ended as told (rule 3)."""
    _tokens: dict[int, set[str]] = field(default_factory=dict)
    """The incarnations of which a token is shown, for each robot that shows one."""
    _heard_s: dict[int, float] = field(default_factory=dict)
    _vanished_s: dict[int, float] = field(default_factory=dict)
    """When a token of each robot vanished last."""
    _incarnations: dict[int, str] = field(default_factory=dict)
    _shown: set[tuple[int, str]] = field(default_factory=set)
    """Robots and incarnations whose tokens have ever been seen."""

    @property
    def missing(self) -> list[int]:
        """Robots that have never come."""
        return sorted(self.robots - self.come)

    @property
    def living(self) -> set[int]:
        """Robots that have come and not died."""
        return self.come - self.dead

    @property
    def present(self) -> Set[int]:
        """Robots that show a token."""
        return self._tokens.keys()

    def recall(
        self,
        come: Set[int],
        dead: Set[int],
        gone: Set[int],
        incarnations: Mapping[int, str],
        *,
        wall_s: float,
    ) -> None:
        """Restore the state from a timeline; tokens are then seen again, or not."""
        self.come |= come
        self.dead |= dead
        self.gone = frozenset(gone)
        self._incarnations.update(incarnations)
        self._shown.update(incarnations.items())
        for robot in come:
            self.hear(robot, wall_s=wall_s)

    def appear(self, robot: int, incarnation: str, *, wall_s: float) -> Coming:
        """A token has appeared."""
        before, dead = self._incarnations.get(robot), robot in self.dead
        self._incarnations[robot] = incarnation
        self._shown.add((robot, incarnation))
        self.come.add(robot)
        self.dead.discard(robot)
        self._tokens.setdefault(robot, set()).add(incarnation)
        self.hear(robot, wall_s=wall_s)
        if before is None:
            return Coming.NEW
        if before != incarnation:
            return Coming.RESTARTED
        return Coming.RETURNED if dead else Coming.KNOWN

    def has_shown(self, robot: int, incarnation: str) -> bool:
        """Whether the token of this process has ever been seen: only then its entries count."""
        return (robot, incarnation) in self._shown

    def vanish(self, robot: int, incarnation: str, *, wall_s: float) -> None:
        """A token has vanished."""
        self._vanished_s[robot] = wall_s
        shown = self._tokens.get(robot, set())
        shown.discard(incarnation)
        if not shown:
            self._tokens.pop(robot, None)

    def hear(self, robot: int, *, wall_s: float) -> None:
        """A message of the robot has arrived."""
        self._heard_s[robot] = wall_s

    def forget_tokens(self, *, wall_s: float) -> None:
        """Forget all tokens after our own absence: existing tokens are reported again."""
        self._tokens.clear()
        self.restart_silence(wall_s=wall_s)

    def silence_s(self, *, wall_s: float) -> float:
        """How long all robots have been silent."""
        return wall_s - max(self._heard_s.values(), default=wall_s)

    def restart_silence(self, *, wall_s: float) -> None:
        """Count silence anew for all robots: at the moment, none can be heard."""
        for robot in self._heard_s:
            self.hear(robot, wall_s=wall_s)

    def lose(self, robots: Set[int]) -> list[int]:
        """These robots have died, even if they still show a token; returns those that were living."""
        newly_dead = sorted(self.living & robots)
        self.dead.update(newly_dead)
        return newly_dead

    def find_deaths(self, *, wall_s: float, excused_s: float = 0.0) -> list[int]:
        """Detect deaths; returns the robots that have died since the last call.

        Args:
            wall_s: the wall clock.
            excused_s: a silence that a machine as late as this one may explain.
        """
        absent = self.come - self.present - self.dead - self.gone
        if not absent:
            return []
        silence_s = max(SILENCE_S, excused_s)
        newly_dead = sorted(
            robot
            for robot in absent
            if wall_s - self._heard_s[robot] >= silence_s
            and wall_s - self._vanished_s.get(robot, -math.inf) >= GONE_S
        )
        self.dead.update(newly_dead)
        return newly_dead
