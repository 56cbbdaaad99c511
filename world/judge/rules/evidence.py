"""What all rules of the judge know of a run: fences, formations, paths, places, deaths.

Rule 1: the world records fences, orders, scans and poses itself, in order. So what was in force when a body
        accepted an order is known at once. What robots record may come later: `claims` waits for it.
Rule 2: what was planned and granted in an epoch is dropped once another epoch is in force and no undecided
        check is about it. Its fences are kept, and the newest formations: an entry about one may come late.
"""

import math
from collections import defaultdict
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field

from protocol.fence import May
from protocol.frames import Point
from protocol.keys import WORLD, robot_number
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    FenceChanged,
    PoseSampled,
    RobotDied,
    ScanServed,
    StepAbandoned,
    StepFinished,
    StepPlanned,
    StrandFormed,
)
from world.judge.rules.claims import ROUNDING_S
from world.judge.rules.fences import Fences
from world.judge.rules.grants import Grants
from world.judge.rules.paths import Paths
from world.judge.rules.standing import Standing

FORMATIONS_KEPT = 8  # 35 kB each with 200 robots
ROUNDING_M = 1e-6  # of sums of arc lengths, computed by one process and checked by another

OF_WORLD = frozenset({FenceChanged, PoseSampled, RobotDied, ScanServed, StepFinished})
OF_ROBOTS = frozenset({AuthorityGranted, StepAbandoned, StepPlanned, StrandFormed})


@dataclass(frozen=True, slots=True)
class Formed:
    """A formation, as a robot recorded it."""

    t_s: float
    by: int
    strand: StrandFormed
    ranks: Mapping[int, int]
    """The rank of each member; the leader's is 0."""

    def is_behind(self, robot: int, other: int) -> bool:
        """Whether a robot is a member directly behind another."""
        members = robot in self.ranks and other in self.ranks
        return members and self.ranks[robot] == self.ranks[other] + 1


@dataclass(slots=True)
class Evidence:
    """The facts of a timeline so far that several rules need."""

    fences: Fences = field(default_factory=Fences)
    formed: dict[int, Formed] = field(default_factory=dict)
    """The first formation recorded of each epoch that is kept."""
    paths: Paths = field(default_factory=Paths)
    grants: Grants = field(default_factory=Grants)
    scanned: dict[int, int] = field(default_factory=dict)
    """The fence in force when a body was last scanned."""
    standing: Standing = field(default_factory=Standing)
    _deaths_s: dict[int, list[float]] = field(default_factory=lambda: defaultdict(list))

    def hear(self, source: str, entry: Entry) -> None:
        """Process an entry."""
        kind = type(entry.record)
        if source == WORLD:
            if kind in OF_WORLD:
                self._hear_world(entry)
        elif kind in OF_ROBOTS and (robot := robot_number(source)) is not None:
            self._hear_robot(robot, entry)

    def _hear_world(self, entry: Entry) -> None:
        match entry.record:
            case FenceChanged() as change:
                self.fences.hear(entry.t_s, change)
                if change.may is May.ALL:
                    self.standing.all_may_move(entry.t_s, change.epoch)
            case PoseSampled() as pose:
                self.standing.sampled(entry.t_s, pose)
            case ScanServed(robot=robot):
                self.scanned[robot] = self.fences.newest
            case StepFinished(robot=robot, step=step):
                self.paths.finish(robot, self.fences.now.epoch, step)
            case RobotDied(robot=robot):
                self._deaths_s[robot].append(entry.t_s)
            case _:
                pass  # no fact that several rules need

    def _hear_robot(self, robot: int, entry: Entry) -> None:
        record = entry.record
        self.paths.hear(robot, entry.t_s, record)
        match record:
            case AuthorityGranted():
                self.grants.hear(robot, entry.t_s, record)
            case StrandFormed() as strand:
                ranks = {each: rank for rank, each in enumerate(strand.order)}
                self.formed.setdefault(strand.epoch, Formed(entry.t_s, robot, strand, ranks))
            case _:
                pass  # of paths

    def forget(self, kept: Collection[int]) -> None:
        """Rule 2: drop what was planned and granted in all other epochs, and their old formations."""
        self.paths.forget(kept)
        self.grants.forget(kept)
        for epoch in sorted(self.formed.keys() - kept)[:-FORMATIONS_KEPT]:
            del self.formed[epoch]

    def may_have_said_more(
        self, robot: int, t_s: float, heard_s: float, *, since_s: float = math.inf
    ) -> bool:
        """Whether entries of a robot up to this time may be missing, because its process was killed.

        It died later, and nothing that it recorded in between has arrived.

        Args:
            robot: the robot.
            t_s: the time.
            heard_s: when the robot was first heard after that time; infinite if it was not.
            since_s: a message of the robot may have arrived long after its death; a death from this time on
                counts too.
        """
        from_s = min(t_s, since_s)
        died_s = next((each_s for each_s in self._deaths_s.get(robot, ()) if each_s >= from_s), None)
        return died_s is not None and (died_s < t_s or heard_s > died_s + ROUNDING_S)


def apart_m(one: Point | PoseSampled, other: Point | PoseSampled) -> float:
    """The distance between two places."""
    return math.hypot(other.x_m - one.x_m, other.y_m - one.y_m)
