"""How a robot advances along the existing path.

Rule 1: it drives to the next vertex or to its authority, whichever comes first, and keeps off robots behind.
Rule 2: it checks each segment against a scan of its own. Where obstacles move, its watch replaces that check.
        It does not on the robot's own leg, nor, if robots are left out, on any path that the formation has
        laid.
Rule 3: after a clear check it drives in the same event.
Rule 4: a follower drives as far as its authority, whether or not its links are silent; without authority it
        stands. The tail of a strand that has turned round comes back only as far as the formation says.
Rule 5: a follower has arrived when the robot ahead has, and there is nothing left to drive.
"""

import math

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command, Note
from agents.navigation.step import LookCloser
from agents.strand.follower import Follower
from agents.strand.strand import Strand
from protocol.mission import Mission
from protocol.path import THERE_M
from protocol.timeline import RobotArrived


class Advance:
    """Drives one robot along the strand's path."""

    def __init__(self, mission: Mission, driver: Driver, senses: Senses, follower: Follower) -> None:
        self._mission = mission
        self._driver = driver
        self._senses = senses
        self._follower = follower
        self.kept_back_at_s = math.inf
        """Since when it has stood because robots behind are in the way."""

    @property
    def refused_at_s(self) -> float:
        """Since when the next segment has not been clear."""
        return self._follower.refused_at_s

    def along(
        self, strand: Strand, authority_m: float, now_s: float, *, final: bool
    ) -> tuple[list[Command], bool]:
        """Drive as far as allowed; also returns whether the robot stands and has nothing to drive."""
        driver = self._driver
        if not driver.standing and driver.drive.target is None:
            return [], False  # the body is being stopped
        ordered_m = driver.progress_m if driver.standing else driver.drive.reach_m
        reach_m = self._reach_m(strand, authority_m, ordered_m=ordered_m, final=final)
        if reach_m is None:
            return [], driver.standing
        reach_m = strand.grants.claim_m(reach_m, progress_m=ordered_m)
        if reach_m <= ordered_m + THERE_M:
            # A robot behind is in the way and may not drive first.
            self.kept_back_at_s = min(self.kept_back_at_s, now_s) if driver.standing else math.inf
            return [], False
        commands = []
        if self._needs_check(strand, reach_m):
            if not driver.standing:
                return [], False  # a part of the segment is clear; the next check is made at its end
            commands = self._check(strand, now_s)
            reach_m = self._follower.clear_part_m(reach_m)
        if reach_m > ordered_m + THERE_M:
            self.kept_back_at_s = math.inf
            driver.to(strand.path.at(reach_m), reach_m=reach_m)
        return commands, False

    def _needs_check(self, strand: Strand, reach_m: float) -> bool:
        """Whether the segment needs a check (rule 2)."""
        # The watch keeps off contact alone; a body that is left out may stand beside all that was laid.
        left_out = strand.members < self._mission.robots
        unsure_m = strand.laid_m if left_out else strand.own_leg_m
        watched = self._mission.obstacles_move and self._driver.progress_m >= unsure_m - THERE_M
        return not watched and not self._follower.is_clear(reach_m)

    def _reach_m(self, strand: Strand, authority_m: float, *, ordered_m: float, final: bool) -> float | None:
        return self._follower.reach_m(
            strand.path,
            progress_m=self._driver.progress_m,
            ordered_m=ordered_m,
            authority_m=authority_m,
            final=final,
        )

    def _check(self, strand: Strand, now_s: float) -> list[Command]:
        """Check the segment that begins where the robot stands; it waits for the scan."""
        scan = self._senses.take()
        if scan is None:
            return self._senses.ask(now_s) if self._follower.may_check(now_s) else []
        checked = self._follower.check(
            scan,
            strand.path,
            progress_m=self._driver.progress_m,
            own_leg_m=strand.own_leg_m,
            robots=strand.robots_in_sight,
            now_s=now_s,
        )
        if isinstance(checked, LookCloser):
            self._senses.look_closer(scan)
            return self._senses.ask(now_s)
        return [Note(checked)]


class Following:
    """The state of a robot that follows."""

    def __init__(self, driver: Driver, strand: Strand, advance: Advance) -> None:
        self._driver = driver
        self._strand = strand
        self._advance = advance
        self._arrived = False

    @property
    def arrived(self) -> bool:
        """Rule 5."""
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
