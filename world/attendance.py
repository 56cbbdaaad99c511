"""Which robots are there, by their liveliness tokens and by what is heard of them [wall-clock seconds].

Rule 1: a robot is there from its first token on; a restarted one shows another incarnation.
Rule 2: a robot has died when it shows no token and has not been heard for `SILENCE_S`: a router that
        loses a token for a moment has killed nobody.
"""

from dataclasses import dataclass, field

SILENCE_S = 1.0  # docs/run.md


@dataclass(slots=True)
class Attendance:
    """Who has come, who shows a token, who has died."""

    robots: frozenset[int]
    come: set[int] = field(default_factory=set)
    dead: set[int] = field(default_factory=set)
    _tokens: dict[int, set[str]] = field(default_factory=dict)
    _heard_s: dict[int, float] = field(default_factory=dict)

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

    def appear(self, robot: int, incarnation: str, *, wall_s: float) -> bool:
        """A token has come; whether it is the robot's first."""
        new = robot not in self.come
        self.come.add(robot)
        self._tokens.setdefault(robot, set()).add(incarnation)
        self.hear(robot, wall_s=wall_s)
        return new

    def vanish(self, robot: int, incarnation: str) -> None:
        """A token has gone."""
        self._tokens.get(robot, set()).discard(incarnation)

    def hear(self, robot: int, *, wall_s: float) -> None:
        """Something has been heard of the robot."""
        self._heard_s[robot] = wall_s

    def bury(self, *, wall_s: float) -> list[int]:
        """The robots that have died since the last time."""
        newly_dead = sorted(
            robot for robot in self.living - self.present if wall_s - self._heard_s[robot] >= SILENCE_S
        )
        self.dead.update(newly_dead)
        return newly_dead
