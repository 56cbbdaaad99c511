"""A fleet that has to recover after the faults: all robots that live are in one strand, and it drives.

Rule 1: a schedule ends when the fleet has recovered. Until then it goes on as without faults, for
        `RECOVERS_S` at most; that it has not recovered by then is the breach.
Rule 2: it has recovered when nothing is under way any more that a fault has held up, all robots that live are
        members under ALL, as their odometry has told them, and a body moves or the leader is at the goal.
"""

import math

from clew.explore.explorable import Breach
from clew.explore.fleet import Fleet
from clew.explore.moments import Moment
from protocol.fence import May
from world.bodies.arena import TICK_S

RECOVERS_S = 60.0  # three times the longest wait but those for views that take very long (docs/strand.md)
AT_GOAL_M = 0.01


class RecoveringFleet(Fleet):
    """Rules 1 and 2."""

    slowest_s = 0.0
    """The longest time to recover so far, from the end of the window."""

    def follow(self, state: Moment) -> Moment | None:
        """Rule 1."""
        if self.is_open(state):
            return super().follow(state)
        passed_s = (state.ticks - self.window[0]) * TICK_S
        if not state.now and self._has_recovered(state):
            self.slowest_s = max(self.slowest_s, passed_s)
            return None
        if passed_s > RECOVERS_S:
            raise Breach("recovery", f"no strand of all robots that live drives after {RECOVERS_S:g} s")
        return self._step(state)

    def _has_recovered(self, state: Moment) -> bool:
        """Rule 2."""
        living = [process for process in state.robots if process is not None]
        fence = self.cores.fences[state.fence]
        if not living:
            return not state.later
        if fence.may is not May.ALL or fence.members != len(living) or state.later:
            return False
        is_told = all(process.told >= 0 and self.cores.fences[process.told] == fence for process in living)
        if not is_told or max(state.cut) > state.ticks:
            return False
        bodies, goal_m = self.cores.world(state.world).bodies, self.setting.goal_m
        off_m = math.dist(bodies.place_m[fence.robot - 1], goal_m)
        return bool(bodies.moving.any()) or off_m <= self._mission.goal_tolerance_m + AT_GOAL_M
