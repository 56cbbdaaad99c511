"""A follower's part in the strand: along the path ahead, as far as it may.

Rule 1: it drives as far as its authority, whether or not its links are silent; without authority it stands.
Rule 2: the tail of a strand that has turned round comes back only as far as the formation says.
Rule 3: it has arrived when the robot ahead has, and there is nothing left to drive.
"""

from agents.body.driver import Driver
from agents.commands import Command, Note
from agents.strand.advance import Advance
from agents.strand.strand import Strand
from protocol.timeline import RobotArrived


class Following:
    """The state of a robot that follows."""

    def __init__(self, driver: Driver, strand: Strand, advance: Advance) -> None:
        self._driver = driver
        self._strand = strand
        self._advance = advance
        self._arrived = False

    @property
    def arrived(self) -> bool:
        """Rule 3."""
        return self._arrived

    def act(self, now_s: float) -> list[Command]:
        """Drive on."""
        strand = self._strand
        state = None if strand.ahead is None else strand.ahead.state
        if state is None:
            return []
        authority_m, final = strand.authority_m, state.arrived
        if strand.behind is None and strand.back_by_m > 0.0:
            final = authority_m >= strand.back_by_m
            authority_m = min(authority_m, strand.back_by_m)
        commands, there = self._advance.along(strand, authority_m, now_s, final=final)
        if there and state.arrived and not self._arrived:
            self._arrived = True
            commands.append(Note(RobotArrived(progress_m=self._driver.progress_m)))
        return commands
