"""What a robot grants those behind it, and the ground that is theirs.

Rule 1: each robot may be where it stands; so that much is granted before anything is said.
Rule 2: what is granted only grows, when it has grown enough to matter.
"""

from agents.commands import Command, Note
from agents.navigation.ground import Ground
from agents.strand.growth import Growth
from protocol.mission import Mission
from protocol.path import THERE_M, Path
from protocol.timeline import AuthorityGranted
from protocol.wire.authority import authority_m, claim_m
from protocol.wire.link import Link
from protocol.wire.messages import BehindState

GRANT_M_MIN = 0.05  # a grant worth a message: a tenth of a second at 0.5 m/s


class Grants:
    """The robots behind one, as far as it knows of them."""

    def __init__(
        self,
        behind: Link[BehindState] | None,
        path: Path,
        mission: Mission,
        *,
        epoch: int,
        own_start_m: float,
        behind_start_m: float,
    ) -> None:
        self._behind = behind
        self._path = path
        self._mission = mission
        self._epoch = epoch
        self._own_start_m = own_start_m
        self.behind_start_m = behind_start_m
        self.granted_m = behind_start_m  # rule 1
        self._taken: tuple[object, ...] = ()

    @property
    def keep_m(self) -> float:
        """Least distance of the centre from ground that robots behind may be on; 0: nobody is behind."""
        return 0.0 if self._behind is None else self._mission.robot_keep_m

    @property
    def tail_m(self) -> float:
        """Arc length behind which there is nobody, as far as is known."""
        if self._behind is None:
            return self._own_start_m
        return self._behind.state.tail_progress_m if self._behind.state else 0.0

    def claim_m(self, to_m: float, *, progress_m: float) -> float:
        """How much of the way to an arc length keeps off the robots behind."""
        if self._behind is None:
            return to_m
        return claim_m(
            self._path,
            progress_m=progress_m,
            to_m=to_m,
            tail_m=self.tail_m,
            granted_m=self.granted_m,
            # The path of a step that kept just so far from granted ground is as far off as the drive was.
            keep_m=self.keep_m - self._mission.mu0_m,
        )

    @property
    def ground(self) -> Ground:
        """What the robots behind take up."""
        return Ground(
            self._path,
            self.tail_m,
            self.granted_m,
            self.keep_m,
            self._behind_m,
            min(self.granted_m, self._behind_m + self.way_m),
        )

    @property
    def _behind_m(self) -> float:
        """Where the robot behind was, when it was last heard."""
        if self._behind is None or self._behind.state is None:
            return self.behind_start_m
        return self._behind.state.progress_m

    @property
    def way_m(self) -> float:
        """How far a robot that has just been heard may have come since: two heartbeats' way."""
        return 2.0 * self._mission.heartbeat_s * self._mission.speed_mps

    @property
    def stretch_m(self) -> float:
        """How far the robot behind is short of what it has been granted."""
        if self._behind is None or self._behind.state is None:
            return 0.0  # nobody lags who has not been heard
        return max(0.0, self.granted_m - self._behind_m)

    def grant(self, growth: Growth, *, progress_m: float, arrived: bool) -> list[Command]:
        """Rule 2: grant what this robot has left behind it."""
        if self._behind is None:
            return []
        taken = (self.granted_m, progress_m, len(self._path), growth.pending, arrived)
        if taken == self._taken:
            return []  # nothing has moved, so nothing has become free
        self._taken = taken
        from_m, enough_m = max(self.tail_m, self.granted_m), 0.0 if arrived else GRANT_M_MIN
        # Along the path is no shorter than straight: what is free ends `keep_m` before this robot, or sooner.
        most_m = max(from_m, progress_m - self.keep_m + THERE_M)
        if most_m <= self.granted_m + enough_m:
            return []
        free_m = authority_m(growth.planned, from_m=from_m, progress_m=progress_m, keep_m=self.keep_m)
        free_m = min(free_m, self._path.end_m)  # what is planned beyond has not been told
        if free_m <= self.granted_m + enough_m:
            return []
        self.granted_m = free_m
        grant = AuthorityGranted(to=self._behind.neighbour, epoch=self._epoch, authority_m=free_m)
        return [Note(grant)]
