"""When a robot's way in the strand counts as blocked: a reason for a new view. Liveness.

Rule 1: a robot whose way has been blocked for too long wants the strand to dissolve: by what it sees, or by
        robots behind it that have come to stand. One that waits for the robot behind is not blocked. A block
        that goes away before the fence has risen changes nothing.
"""

from agents.body.watch import STILL_S_MAX, Watch
from agents.liveness.reason import Reason
from agents.strand.advance import Advance
from agents.strand.strand import Strand
from protocol.fence import Cause
from protocol.mission import Mission

BLOCKED_S = 5.0  # five checks; on ground where nothing moves only a robot out of its place goes away


class Blocked:
    """Whether one robot of a strand is blocked."""

    def __init__(self, mission: Mission, strand: Strand, advance: Advance, watch: Watch) -> None:
        self._strand = strand
        self._advance = advance
        self._watch = watch
        self._patience_s = STILL_S_MAX if mission.obstacles_move else BLOCKED_S

    def is_so(self, now_s: float) -> bool:
        """Rule 1, of a robot that does not wait."""
        stopped_at_s = min(self._advance.refused_at_s, self._watch.still_since_s)
        if self._strand.quiet_s >= self._patience_s:
            stopped_at_s = min(stopped_at_s, self._advance.kept_back_at_s)
        return now_s - stopped_at_s >= self._patience_s

    @property
    def reason(self) -> Reason:
        """Why it wants a new view when it is blocked."""
        robot = self._strand.robot
        return Reason(Cause.BLOCKED, f"the way of robot {robot} is blocked", about=robot)
