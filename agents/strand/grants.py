"""The grants of a robot to the robot behind it, and the ground that robots behind may occupy.

Rule 1: each robot may be where it stands, so that much is granted from the start.
Rule 2: a grant only grows, and only when it grows enough to matter.
Rule 3: a robot behind that was never heard counts as standing at its place in the formation. So a robot that
        hears nobody stops when the strand is stretched (17).
Rule 4 (safety): a leader that began too near to something grants nothing more, so nobody comes to where it
        began; once it has arrived there, it stays, and grants the ground up to it.
Rule 5: a leader that robots behind have kept from a turn also grants no ground beside the way that it is
        likely to go on (`agents.strand.leader`). Liveness.
"""

from agents.commands import Command, Note
from agents.navigation.ground import Ground
from agents.strand.growth import Growth
from protocol.mission import Mission
from protocol.path import THERE_M, Path
from protocol.timeline import AuthorityGranted
from protocol.wire.authority import authority_m, claim_m, free_until_m
from protocol.wire.link import Link
from protocol.wire.messages import BehindState

ONWARD_M = 0.05  # a way of guidance is a row of cells, which are at most this wide (`CELL_M_MAX`)
GRANT_M_MIN = 0.05  # a grant worth a message: a tenth of a second at 0.5 m/s


class Grants:
    """What a robot knows of the robots behind it, and what it has granted."""

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
        self._withheld = False

    def withhold(self, *, too_near: bool) -> None:
        """Grant nothing from now on, or grant again: what the newest scan of the place shows (rule 4)."""
        self._withheld = too_near

    @property
    def withheld(self) -> bool:
        """Whether nobody may come to where this robot began."""
        return self._withheld

    @property
    def keep_m(self) -> float:
        """Least distance of the centre from the ground of robots behind; 0 if no robot is behind."""
        return 0.0 if self._behind is None else self._mission.robot_keep_m

    @property
    def tail_m(self) -> float:
        """The last known arc length of the tail; no robot is behind it."""
        if self._behind is None:
            return self._own_start_m
        return self._behind.state.tail_progress_m if self._behind.state else 0.0

    def claim_m(self, to_m: float, *, progress_m: float) -> float:
        """How far towards `to_m` the robot can drive and keep off the robots behind."""
        if self._behind is None:
            return to_m
        return claim_m(
            self._path,
            progress_m=progress_m,
            to_m=to_m,
            tail_m=self.tail_m,
            granted_m=self.granted_m,
            # The driven path of a step that just kept the distance may be nearer by the drive error.
            keep_m=self.keep_m - self._mission.mu0_m,
        )

    @property
    def ground(self) -> Ground:
        """The ground that the robots behind may occupy."""
        return Ground(self._path, self.tail_m, self.granted_m, self.keep_m, self.behind_m)

    @property
    def behind_m(self) -> float:
        """The last reported position of the robot behind (rule 3)."""
        if self._behind is None or self._behind.state is None:
            return self.behind_start_m
        return self._behind.state.progress_m

    @property
    def stretch_m(self) -> float:
        """How far the robot behind is from the end of its grant; 0 if no robot is behind."""
        return 0.0 if self._behind is None else max(0.0, self.granted_m - self.behind_m)

    def grant(self, growth: Growth, *, progress_m: float, arrived: bool) -> list[Command]:
        """Grant the ground that this robot has left (rule 2)."""
        if self._behind is None or self._withheld:
            return []
        taken = (self.granted_m, progress_m, len(self._path), growth.pending, growth.onward, arrived)
        if taken == self._taken:
            return []  # nothing has changed, so no more ground is free
        self._taken = taken
        from_m, enough_m = max(self.tail_m, self.granted_m), 0.0 if arrived else GRANT_M_MIN
        keep_m = self._mission.grant_keep_m
        # The path is at least as long as the straight line, so at most this much can be free.
        most_m = max(from_m, progress_m - keep_m + THERE_M)
        if most_m <= self.granted_m + enough_m:
            return []
        free_m = authority_m(growth.planned, from_m=from_m, progress_m=progress_m, keep_m=keep_m)
        if len(growth.onward) > 1 and not arrived:
            beside_m = keep_m + ONWARD_M
            free_m = min(free_m, free_until_m(self._path, from_m, free_m, growth.onward, beside_m))
        free_m = min(free_m, self._path.end_m)  # the path planned beyond has not been sent yet
        if free_m <= self.granted_m + enough_m:
            return []
        self.granted_m = free_m
        grant = AuthorityGranted(to=self._behind.neighbour, epoch=self._epoch, authority_m=free_m)
        return [Note(grant)]
