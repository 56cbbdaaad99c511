"""What is known of the strand of one epoch, by which the claims of its members are judged."""

from collections import defaultdict
from dataclasses import dataclass, field
from math import inf

from protocol.frames import Point
from protocol.path import Path
from protocol.timeline import StrandFormed


@dataclass(frozen=True, slots=True)
class ArrivalClaim:
    """What a robot has recorded of its arrival."""

    t_s: float
    robot: int
    epoch: int
    progress_m: float | None
    """Along the strand's path; None: the goal is reached."""
    stood: Point | None = None
    """Where its body was."""


@dataclass(slots=True)
class Strand:
    """What is known of the strand of one epoch."""

    leader: int = 0
    formed: StrandFormed | None = None
    ranks: dict[int, int] = field(default_factory=dict)
    """Of its members."""
    until_s: float = inf
    """When its epoch was no longer in force."""
    reached: set[int] = field(default_factory=set)
    """The robots that have claimed to have reached the goal in it."""
    arrived: dict[int, ArrivalClaim] = field(default_factory=dict)
    """The newest claim of each robot, if it has been judged."""
    untrue: set[int] = field(default_factory=set)
    """The robots that did not stand where they said: nobody behind is judged by that."""
    waiting: dict[int, list[ArrivalClaim]] = field(default_factory=lambda: defaultdict(list))
    """Claims, by the robot ahead, which has claimed nothing yet; 0: the formation is missing."""
    _targets: dict[int, Point] = field(default_factory=dict)
    """The ends of the leader's steps."""
    _path: Path | None = None

    def lead(self, robot: int) -> None:
        """The fence lets all move, with this leader."""
        self.leader = robot

    def end(self, t_s: float) -> None:
        """Another epoch is in force from now on."""
        self.until_s = t_s

    def judge(self, claim: ArrivalClaim) -> list[ArrivalClaim]:
        """The robot of this claim has its place; returns the claims that have waited for it."""
        self.arrived[claim.robot] = claim
        return self.waiting.pop(claim.robot, [])

    def step_to(self, step: int, end: Point) -> None:
        """The leader has planned a step, or ended it."""
        self._targets[step], self._path = end, None

    def form(self, formed: StrandFormed) -> None:
        """Its formation has been recorded."""
        self.formed, self.ranks = formed, {robot: rank for rank, robot in enumerate(formed.order)}

    def waits_for(self, robot: int) -> int:
        """The robot ahead; 0 for the leader."""
        assert self.formed is not None, "claims wait for the formation"
        rank = self.ranks[robot]
        return self.formed.order[rank - 1] if rank else 0

    def place_m(self, robot: int) -> float:
        """The place of a member in the formation."""
        assert self.formed is not None, "claims wait for the formation"
        return self.formed.places_m[self.ranks[robot]]

    @property
    def path(self) -> Path:
        """What the formation laid, and then the leader's steps."""
        assert self.formed is not None, "claims wait for the formation"
        if self._path is None:
            self._path = Path(self.formed.laid)
            for step in sorted(self._targets):
                self._path.extend(self._targets[step])
        return self._path

    @property
    def end_m(self) -> float:
        """The arc length of the leader's last switching position."""
        assert self.formed is not None, "claims wait for the formation"
        return self.path.end_m if self._targets else self.formed.places_m[0]
