"""A robot that follows: from vertex to vertex of the path ahead (16)-(17), as far as its authority.

Rule 1: it drives to the next vertex or to its authority, whichever comes first.
Rule 2: before it enters a segment it checks it against a scan of its own: the strand's own robots apart,
        nothing may stand nearer than the clearance that the leader was promised. Under a law that
        promises none, robots that follow do not sense.
Rule 3: a segment that is not clear is checked again every `RECHECK_S`; meanwhile the robot stands.
"""

import math

import numpy as np

from agents.scan import View, on_ground
from protocol.arrays import distances_to_segments
from protocol.frames import Point
from protocol.mission import Mission
from protocol.path import Path
from protocol.timeline import SegmentChecked

RECHECK_S = 1.0
DRIVE_M_MIN = 0.05  # a grant of less, short of a vertex, waits for the next one
THERE_M = 1e-6  # nearer than this to an arc length counts as there: rounding of sums of metres


class Follower:
    """What a robot that follows remembers from segment to segment."""

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._clear_until_m = -math.inf
        self._checked_at_s = -math.inf

    def reach_m(
        self, path: Path, *, progress_m: float, ordered_m: float, authority_m: float, final: bool
    ) -> float | None:
        """Rule 1: how far to drive now, in arc length; None where that adds nothing worth an order.

        Args:
            path: the path ahead.
            progress_m: where the robot is on it.
            ordered_m: how far it has been sent already.
            authority_m: how far it may go.
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
        """Whether the segment up to there has been checked."""
        return not self._mission.law.promises_clearance or reach_m <= self._clear_until_m + THERE_M

    def may_check(self, now_s: float) -> bool:
        """Rule 3."""
        return now_s - self._checked_at_s >= RECHECK_S

    def check(
        self, view: View, path: Path, *, progress_m: float, authority_m: float, now_s: float
    ) -> SegmentChecked:
        """Rule 2: check the segment that begins here."""
        vertex = path[path.next_vertex(progress_m + THERE_M)]
        clearance_m = self._clearance_m(view, path, vertex.s_m, progress_m, authority_m)
        # Twice the tolerance: once for where this robot stands, once for where the leader stood.
        clear = clearance_m >= self._mission.epsilon_m - 2.0 * self._mission.mu0_m
        self._checked_at_s = now_s
        if clear:
            self._clear_until_m = vertex.s_m
            self._checked_at_s = -math.inf
        return SegmentChecked(
            target=Point(x_m=vertex.x_m, y_m=vertex.y_m), clear=clear, clearance_m=clearance_m
        )

    def _clearance_m(
        self, view: View, path: Path, vertex_m: float, progress_m: float, authority_m: float
    ) -> float:
        hull_m = self._mission.hull_reach_m
        behind = on_ground(view.points, path.between(0.0, progress_m), within_m=hull_m)
        ahead = on_ground(view.points, path.between(authority_m, path.end_m), within_m=hull_m)
        hits = view.without(behind | ahead).hit_points
        end = path.at(vertex_m)
        distances = distances_to_segments(hits, view.position, np.array([end.x_m, end.y_m]))
        nearest_m = float(distances.min(initial=self._mission.range_m_max))
        return nearest_m - self._mission.robot_radius_m
