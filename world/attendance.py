"""Which robots are there, by their liveliness tokens and by what is heard of them [wall-clock seconds].

Rule 1: a robot is there from its first token on.
Rule 2: a robot has died when it shows no token and has not been heard for `SILENCE_S`: a router that
        loses a token for a moment has killed nobody.
Rule 3: who has gone as it was told to, when the run was over, has not died; a world that goes on from its
        timeline finds out there who that is.
Rule 4: a dead robot that shows a token lives again. If the token bears another incarnation it was started
        again; else it was frozen, or cut off. One that was started again has died before, known or not.
"""

from collections.abc import Mapping, Set
from dataclasses import dataclass, field
from enum import Enum, auto

SILENCE_S = 1.0  # docs/run.md


class Coming(Enum):
    """What a token that has come says."""

    NEW = auto()
    RESTARTED = auto()
    RETURNED = auto()
    KNOWN = auto()  # it was never missed


@dataclass(slots=True)
class Attendance:
    """Who has come, who shows a token, who has died."""

    robots: frozenset[int]
    come: set[int] = field(default_factory=set)
    dead: set[int] = field(default_factory=set)
    gone: frozenset[int] = frozenset()
    """Rule 3."""
    _tokens: dict[int, set[str]] = field(default_factory=dict)
    _heard_s: dict[int, float] = field(default_factory=dict)
    _incarnations: dict[int, str] = field(default_factory=dict)

    @property
    def missing(self) -> list[int]:
        """Robots that have never come."""
        return sorted(self.robots - self.come)

    @property
    def living(self) -> set[int]:
        """Robots that have come and not died."""
        return self.come - self.dead

    @property
    def present(self) -> set[int]:
        """Robots that show a token."""
        return {robot for robot, tokens in self._tokens.items() if tokens}

    def recall(
        self,
        come: Set[int],
        dead: Set[int],
        gone: Set[int],
        incarnations: Mapping[int, str],
        *,
        wall_s: float,
    ) -> None:
        """Who had come, died and gone by what a timeline says; their tokens are seen again, or not."""
        self.come |= come
        self.dead |= dead
        self.gone = frozenset(gone)
        self._incarnations.update(incarnations)
        for robot in come:
            self.hear(robot, wall_s=wall_s)

    def appear(self, robot: int, incarnation: str, *, wall_s: float) -> Coming:
        """A token has come."""
        before, dead = self._incarnations.get(robot), robot in self.dead
        self._incarnations[robot] = incarnation
        self.come.add(robot)
        self.dead.discard(robot)
        self._tokens.setdefault(robot, set()).add(incarnation)
        self.hear(robot, wall_s=wall_s)
        if before is None:
            return Coming.NEW
        if before != incarnation:
            return Coming.RESTARTED
        return Coming.RETURNED if dead else Coming.KNOWN

    def vanish(self, robot: int, incarnation: str) -> None:
        """A token has gone."""
        self._tokens.get(robot, set()).discard(incarnation)

    def hear(self, robot: int, *, wall_s: float) -> None:
        """Something has been heard of the robot."""
        self._heard_s[robot] = wall_s

    def forget_tokens(self, *, wall_s: float) -> None:
        """This process has just come back: it is told anew of the tokens that there are."""
        self._tokens.clear()
        self.excuse(wall_s=wall_s)

    def silence_s(self, *, wall_s: float) -> float:
        """For how long nothing has been heard of any robot."""
        return wall_s - max(self._heard_s.values(), default=wall_s)

    def excuse(self, *, wall_s: float) -> None:
        """Nobody can be heard at the moment: that counts against nobody."""
        for robot in self._heard_s:
            self.hear(robot, wall_s=wall_s)

    def bury(self, *, wall_s: float) -> list[int]:
        """The robots that have died since the last time."""
        absent = self.come - self.present - self.dead - self.gone
        newly_dead = sorted(robot for robot in absent if wall_s - self._heard_s[robot] >= SILENCE_S)
        self.dead.update(newly_dead)
        return newly_dead
