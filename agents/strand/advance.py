"""How a robot advances along the existing path.

Rule 1: it drives to the next vertex or to its authority, whichever comes first, and keeps off robots behind.
Rule 2: it checks each segment against a scan of its own. Where obstacles move, its watch replaces that check.
        It does not on the robot's own leg, nor, if robots are left out, on any path that the formation has
        laid.
Rule 3: after a clear check it drives in the same event.
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


class Advance:
    """Drives one robot along the strand's path."""

    def __init__(self, mission: Mission, driver: Driver, senses: Senses, follower: Follower) -> None:
        self._mission = mission
        self._driver = driver
        self._senses = senses
        self._follower = follower
        self.kept_back_at_s = math.inf
        """Since when it has stood because robots behind are in the way."""

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
            robots=strand.robots_in_sight(now_s),
            now_s=now_s,
        )
        if isinstance(checked, LookCloser):
            self._senses.look_closer(scan)
            return self._senses.ask(now_s)
        return [Note(checked)]
