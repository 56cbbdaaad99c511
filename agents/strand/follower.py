"""A follower: drives from vertex to vertex of the path ahead (16)-(17), as far as its authority.

Rule 1: it drives to the next vertex or to its authority, whichever comes first.
Rule 2: before it enters a segment, it checks the segment against a scan of its own. Except for robots of the
        strand, nothing may be nearer than the leader's promise, minus twice the tolerance: one for the place
        of this robot, one for that of the leader.
        - No leader has certified its own leg, up to where the robot ahead stood at first. There the check
          must certify `epsilon - mu0`, with half of the tolerance left for the drive.
        - A robot that is left out may have died on a leg that counts as driven, or just behind it. So hits
          count as robots of the strand only where its neighbours may be (`Strand.robots_in_sight`), and
          ground that was checked in another epoch is checked anew.
        - Bodies of robots that are left out may have stopped beside ground that was driven before. Then the
          check requires the whole promise, minus the range error and part of the tolerance.
        - Under a law that promises nothing, followers do not sense.
Rule 3: a segment that is not clear is checked again every `RECHECK_S`; meanwhile the robot stands.
"""

import math
from collections.abc import Sequence

import numpy as np

from agents.navigation.leg import certain_clearance_m, is_unsure_of_leg, leg_is_certain, seen_clearance_m
from agents.navigation.scan import View, on_ground
from agents.navigation.step import LookCloser
from agents.navigation.sure import closer
from protocol.arrays import Floats, xy
from protocol.frames import Point
from protocol.mission import Mission
from protocol.path import THERE_M, Path
from protocol.timeline import SegmentChecked

RECHECK_S = 1.0
DRIVE_M_MIN = 0.05  # a smaller grant, short of a vertex, waits for the next grant


class Follower:
    """The state of a follower from segment to segment."""

    def __init__(self, mission: Mission, start_m: float, *, some_are_left_out: bool = False) -> None:
        self._mission = mission
        less_m = mission.seen_less_m if some_are_left_out else 2.0 * mission.mu0_m
        self._clear_m_min = mission.clear_m - less_m
        """The clearance to be seen beside a segment that another robot has driven (rule 2)."""
        self._clear_until_m = start_m
        self._checked_at_s = -math.inf
        self.refused_at_s = math.inf
        """Since when the next segment has not been clear."""

    def reach_m(
        self, path: Path, *, progress_m: float, ordered_m: float, authority_m: float, final: bool
    ) -> float | None:
        """The arc length to drive to now (rule 1); None if that is not worth an order.

        Args:
            path: the path ahead.
            progress_m: the robot's arc length on it.
            ordered_m: the arc length of the current order.
            authority_m: the robot's authority.
            final: whether the authority will not grow any more.
        """
        vertex = path.next_vertex(progress_m + THERE_M)
        if vertex == len(path):
            return None
        vertex_m = path[vertex].s_m
        reach_m = min(vertex_m, authority_m)
        least_m = THERE_M if final or reach_m == vertex_m else DRIVE_M_MIN
        return reach_m if reach_m - ordered_m > least_m else None

    def is_clear(self, reach_m: float) -> bool:
        """Whether the segment up to `reach_m` has been checked and is clear."""
        return not self._mission.promises_clearance or reach_m <= self._clear_until_m + THERE_M

    def may_check(self, now_s: float) -> bool:
        """Whether it is time for the next check (rule 3)."""
        return now_s - self._checked_at_s >= RECHECK_S

    def check(
        self,
        view: View,
        path: Path,
        *,
        progress_m: float,
        own_leg_m: float,
        robots: Sequence[Floats],
        now_s: float,
    ) -> SegmentChecked | LookCloser:
        """Check the segment that begins here (rule 2), if the scan shows enough.

        Args:
            view: a scan taken here.
            path: the path ahead.
            progress_m: the robot's arc length on it.
            own_leg_m: up to here no robot has driven and no leader has certified the path.
            robots: polylines (n, 2) of ground on which hits are robots of the strand.
            now_s: the time.
        """
        vertex = path[path.next_vertex(progress_m + THERE_M)]
        seen = self._without(view, robots)
        clearance_m = seen_clearance_m(seen, xy(vertex), self._mission)
        clear = clearance_m >= self._clear_m_min
        if progress_m < own_leg_m - THERE_M:
            end = xy(path.at(min(vertex.s_m, own_leg_m)))
            is_closest = closer(self._mission, len(view.ranges_m)) is None
            if clear and not is_closest and is_unsure_of_leg(seen, end, self._mission):
                return LookCloser()
            clear = clear and leg_is_certain(seen, end, self._mission)
            clearance_m = min(clearance_m, certain_clearance_m(seen, end, self._mission))
        self._checked_at_s, self.refused_at_s = now_s, min(self.refused_at_s, now_s)
        if clear:
            self._clear_until_m = vertex.s_m
            self._checked_at_s, self.refused_at_s = -math.inf, math.inf
        target = Point(x_m=vertex.x_m, y_m=vertex.y_m)
        return SegmentChecked(target=target, clear=clear, clearance_m=clearance_m)

    def _without(self, view: View, robots: Sequence[Floats]) -> View:
        seen = np.zeros(len(view.ranges_m), dtype=np.bool_)
        for ground in robots:
            seen |= on_ground(view.points, ground, within_m=self._mission.hull_reach_m)
        return view.without(seen)
