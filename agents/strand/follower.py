"""A follower: drives from vertex to vertex of the path ahead (16)-(17), as far as its authority.

Rule 1: it drives to the next vertex or to its authority, whichever comes first, and by one order no further
        than a scan reaches: `mu0` covers the drive error of such a length. It drives on from a vertex when it
        stands there: a scan from before a corner permits no way round it (`agents.body.watch`).
Rule 2: before it enters a segment, it checks the segment against a scan of its own. Except for robots of the
        strand, nothing may be nearer than the leader's promise, minus twice the tolerance: one for the place
        of this robot, one for that of the leader.
        - No leader has certified its own leg, up to where the robot ahead stood at first. There the check
          must certify `epsilon - mu0`, with half of the tolerance left for the drive.
        - A robot that is left out may have died on a leg that counts as driven, or just behind it. So hits
          count as robots of the strand only where its neighbours may be (`Strand.robots_in_sight`), and
          ground that was checked in another epoch is checked anew.
        - Bodies of robots that are left out may have stopped beside ground that was driven before. Then the
          robot keeps the whole promise, minus part of the tolerance, from wherever the body of a robot may
          be: between two rays, and beyond the range, too. Where that is not sure of the whole segment, a part
          of it is cleared.
        - Under a law that promises nothing, followers do not sense.
Rule 3: a segment that is not clear is checked again every `RECHECK_S`; meanwhile the robot stands.
"""

import math
from collections.abc import Sequence

from agents.navigation.leg import (
    body_clearance_m,
    certain_clearance_m,
    certain_clearance_m_min,
    leg_meets_nothing,
    seen_clearance_m,
)
from agents.navigation.scan import View
from agents.navigation.step import LookCloser
from agents.navigation.sure import closer
from protocol.arrays import Floats, xy
from protocol.mission import SEEN_SHARE, Mission
from protocol.path import THERE_M, Path
from protocol.timeline import SegmentChecked

RECHECK_S = 1.0
DRIVE_M_MIN = 0.05  # a smaller grant, short of a vertex, waits for the next grant


class Follower:
    """The state of a follower from segment to segment."""

    def __init__(self, mission: Mission, start_m: float, *, some_are_left_out: bool = False) -> None:
        self._mission = mission
        self._bodies_left_out = some_are_left_out and mission.robot_radius_m > 0.0
        self._bodies_clear_m = mission.clear_m - SEEN_SHARE * mission.mu0_m
        in_sight_m = mission.range_m_max - mission.range_error_m_max - mission.mu0_m
        self._bodies_seen_m = max(0.0, in_sight_m - 2.0 * mission.robot_radius_m - mission.clear_m)
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
        is_under_way = ordered_m > progress_m
        vertex = path.next_vertex(progress_m if is_under_way else progress_m + THERE_M)
        if vertex == len(path):
            return None
        vertex_m = path[vertex].s_m
        reach_m = min(vertex_m, authority_m, progress_m + self._mission.range_m_max)
        least_m = THERE_M if final or reach_m == vertex_m else DRIVE_M_MIN
        return reach_m if reach_m - ordered_m > least_m else None

    def is_clear(self, reach_m: float) -> bool:
        """Whether the segment up to `reach_m` has been checked and is clear."""
        return not self._mission.promises_clearance or reach_m <= self._clear_until_m + THERE_M

    def clear_part_m(self, reach_m: float) -> float:
        """How far of the way up to `reach_m` has been checked and is clear."""
        return reach_m if self.is_clear(reach_m) else self._clear_until_m

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
        mission = self._mission
        vertex = path[path.next_vertex(progress_m + THERE_M)]
        seen = view.without_on(robots, within_m=mission.hull_reach_m)
        clearance_m = seen_clearance_m(seen, xy(vertex), mission)
        clear = clearance_m >= mission.clear_m - 2.0 * mission.mu0_m
        may_look_closer = clear and closer(mission, len(view.ranges_m)) is not None
        if progress_m < own_leg_m - THERE_M:
            end = xy(path.at(min(vertex.s_m, own_leg_m)))
            certain_m = certain_clearance_m(seen, end, mission)
            is_certain = certain_m >= certain_clearance_m_min(mission)
            if may_look_closer and not is_certain and leg_meets_nothing(seen, end, mission):
                return LookCloser()
            clear = clear and is_certain
            clearance_m = min(clearance_m, certain_m)
        until_m = vertex.s_m
        if self._bodies_left_out:
            seen_m = min(vertex.s_m, progress_m + self._bodies_seen_m)
            until_m = self._free_of_bodies_until_m(seen, path, progress_m, seen_m)
            if may_look_closer and until_m < seen_m:
                return LookCloser()
            clear = clear and until_m > progress_m
            clearance_m = min(clearance_m, body_clearance_m(seen, xy(path.at(until_m)), mission))
        self._checked_at_s, self.refused_at_s = now_s, min(self.refused_at_s, now_s)
        if clear:
            self._clear_until_m = until_m
            self._checked_at_s, self.refused_at_s = -math.inf, math.inf
        return SegmentChecked(target=path.at(until_m), clear=clear, clearance_m=clearance_m)

    def _free_of_bodies_until_m(self, seen: View, path: Path, from_m: float, to_m: float) -> float:
        """Up to which arc length of a segment the body of no robot can be too near (rule 2)."""
        length_m = to_m - from_m
        while body_clearance_m(seen, xy(path.at(from_m + length_m)), self._mission) < self._bodies_clear_m:
            length_m /= 2.0
            if length_m < DRIVE_M_MIN:
                return from_m
        return from_m + length_m
