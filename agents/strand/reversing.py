"""The first robot's part in a strand that has turned round, until its tail has come back far enough.

Rule 1: it drives along the path that there is, so that the robots behind can come back.
Rule 2: when the tail has come back as far as the formation says, it wants the strand to turn round again: the
        tail then leads from there.
Rule 3: where the path ends, and all robots behind stand, it stays the leader if it knows a way; otherwise it
        makes room by a step, a limited number of times (`agents.strand.leader`).
"""

from agents.body.driver import Driver
from agents.commands import Command
from agents.liveness.reason import Reason, Turnabout
from agents.strand.advance import Advance
from agents.strand.leading import SETTLED_S, Leading
from agents.strand.strand import Strand
from protocol.fence import Cause
from protocol.path import THERE_M


class Reversing:
    """The state of a robot that backs up ahead of the strand."""

    def __init__(self, driver: Driver, strand: Strand, advance: Advance, leading: Leading) -> None:
        self._driver = driver
        self._strand = strand
        self._advance = advance
        self._leading = leading
        self._reason: Reason | None = None

    @property
    def reason(self) -> Reason | None:
        """Why it wants a new view; None: it wants none."""
        return self._reason or self._leading.reason

    def act(self, now_s: float) -> list[Command]:
        """Back up, as far as there is a path; then make room."""
        strand, driver = self._strand, self._driver
        if strand.grants.tail_m >= strand.back_by_m - THERE_M:
            self._turn()
            return []
        if self._leading.has_step:
            return self._leading.finish_step()
        if driver.standing and driver.progress_m >= strand.path.end_m - THERE_M:
            if strand.quiet_s < SETTLED_S:
                return []  # those behind may still be on their way back
            return self._leading.plan(now_s, room_m=strand.back_by_m - strand.grants.tail_m)
        return self._advance.along(strand, strand.path.end_m, now_s, final=True)[0]

    def _turn(self) -> None:
        """Rule 2."""
        strand, driver = self._strand, self._driver
        driver.stand()
        if driver.standing and self._reason is None:
            turnabout = Turnabout(cut_m=strand.back_by_m, end_m=driver.progress_m, back_by_m=0.0)
            self._reason = Reason(Cause.DEAD_END, "the tail has come back far enough", turnabout=turnabout)
