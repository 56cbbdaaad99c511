"""The certificate: the clearance that holds along a whole step, promised before the step is driven.

Rule 1: ground is free as far as the scan is sure of it (`agents/navigation/sure.py`). Where that ends is a
        wall, since nothing is known beyond: an arc between two rays, and a side along a ray between two arcs.
Rule 2: a step is certified if the disc of radius r + epsilon, swept along it, stays inside.
Rule 3: a step keeps the robots' distance from ground that robots behind may still reach. From the bounds of
        the region it keeps the hull's radius and the tolerance.
Rule 4: an edge that is already nearer than its distance forbids motion that does not lead away from it, as
        far as it is nearer, by what a drive may be off. Else a leader could drive beside a long edge or round
        a post for ever, and each drive error would bring it nearer.
Rule 5: a short step, which leads to another place to look from, keeps all of that from what was hit and from
        robots' bodies, and half of the tolerance less from sharper corners that two rays may hide. The rest
        of the tolerance is for the drive: on a way so short it errs by an eighth of its share at most
        (`world/scenario/budget.py`). The range error is none of it, since a scan is sure of nothing within.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from agents.navigation.scan import View
from agents.navigation.sure import Sure, sure
from protocol.arrays import Flags, Floats, nearest_on_segments, of_next, segments_apart, unit_vectors
from protocol.mission import Bounds, Mission
from protocol.sweep import Stadiums, cut_where_near

SHORT_STEP_EASE = 0.5  # of the tolerance, as on a leg that no leader has certified (`leg.py`)
SHORT_STEP_SHARE = 1 / 8  # of the range; 3 cm of another place are enough in a corridor one robot wide


@dataclass(frozen=True)
class Walls:
    """Segments, each with the distance that a robot's centre must keep from it [m; world frame]."""

    starts: Floats
    ends: Floats
    keep_m: Floats
    away: float = 0.0
    """Sine of the angle by which a motion leads away from an edge that is nearer than that (rule 4)."""

    @cached_property
    def _seen_from(self) -> dict[bytes, Stadiums]:
        return {}

    def seen_from(self, origin: Floats) -> Stadiums:
        """The same as they lie around a place; a plan asks from one place some times."""
        place = origin.tobytes()
        if place not in self._seen_from:
            cut = cut_where_near(origin, self.starts, self.ends, self.keep_m)
            self._seen_from[place] = Stadiums(origin, *cut, away=self.away)
        return self._seen_from[place]

    def eased(self, origin: Floats, least_m: Floats) -> "Walls":
        """The same for a robot that already stands nearer to some edges: it may pass these at `least_m`."""
        off = nearest_on_segments(origin, self.starts, self.ends) - origin
        # With as much margin: some edges of one hull are nearer than that, and the next edge just not.
        near = np.hypot(off[:, 0], off[:, 1]) < 2.0 * self.keep_m - least_m
        return replace(self, keep_m=np.where(near, np.minimum(self.keep_m, least_m), self.keep_m))

    @staticmethod
    def joined(*parts: "Walls") -> "Walls":
        """All segments of several walls."""
        return Walls(
            np.concatenate([part.starts for part in parts]),
            np.concatenate([part.ends for part in parts]),
            np.concatenate([part.keep_m for part in parts]),
            max(part.away for part in parts),
        )


def scan_walls(view: View, mission: Mission, *, leave_out: Flags | None = None) -> Walls:
    """Where the ground ends that a scan is sure of, as walls (rule 1).

    If a direction is left out, the gaps on both sides of it are as its other neighbours say.
    """
    return _walls(sure(view, mission, leave_out=leave_out), mission, mission.obstacle_keep_m)


def short_step_walls(view: View, mission: Mission) -> Walls:
    """The same for a step of at most `short_step_m` where nothing but the strand moves (rule 5)."""
    keep_m = mission.obstacle_keep_m
    hit, hidden = sure(view, mission, bodies_only=True), sure(view, mission)
    eased_m = keep_m - SHORT_STEP_EASE * mission.mu0_m
    return Walls.joined(_walls(hit, mission, keep_m), _walls(hidden, mission, eased_m))


def short_step_m(mission: Mission) -> float:
    """The longest short step."""
    return SHORT_STEP_SHARE * mission.range_m_max


def _walls(seen: Sure, mission: Mission, keep_m: float) -> Walls:
    is_known = np.isfinite(seen.ranges_m)
    # The side at the end of a gap: from its arc to the next one's.
    sided = is_known & of_next(is_known) & (seen.ranges_m != of_next(seen.ranges_m))
    starts = np.concatenate([seen.starts[is_known], seen.ends[sided]])
    ends = np.concatenate([seen.ends[is_known], of_next(seen.starts)[sided]])
    return Walls(starts, ends, np.full(len(starts), keep_m), math.sin(mission.drive_off_rad))


def ground_walls(corners: Floats, keep_m: float) -> Walls:
    """A polyline (n, 2) of ground that robots behind may still reach, as walls (rule 3)."""
    return Walls(corners[:-1], corners[1:], np.full(len(corners) - 1, keep_m))


def bounds_walls(bounds: Bounds, mission: Mission) -> Walls:
    """The four sides of the region, as walls (rule 3)."""
    low, high = (bounds.x_m_min, bounds.y_m_min), (bounds.x_m_max, bounds.y_m_max)
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    return Walls(corners, of_next(corners), np.full(4, mission.robot_radius_m + mission.mu0_m))


def certified_lengths_m(origin: Floats, headings_rad: Floats, walls: Walls) -> Floats:
    """The longest certified step in each heading (h,) [m], for all headings against all edges at once."""
    return walls.seen_from(origin).travel_m(unit_vectors(headings_rad))


def promised_clearance_m(view: View, target: Floats, robots: Flags, mission: Mission) -> float:
    """The least clearance of the hull along a step from any obstacle consistent with the scan [m].

    It is less than epsilon only if the step begins nearer than that to something and leads away from it.

    Args:
        view: the scan that the step was planned from; the step begins at its position.
        target: where the step ends (2,) [m; world frame].
        robots: the directions of the scan that hit the robot directly behind. It is no obstacle: grants keep
            the distance to it. What it hides may be one. Robots further behind count as obstacles; so does
            all that is hit where obstacles move: one that moves may be where the robot may be, and hide more.
        mission: the robot's mission.
    """
    past = view if mission.obstacles_move else _past_hulls(view, robots, mission)
    seen = sure(past, mission)
    # The arcs are enough: what lies further along a ray from where a step begins is further from the step.
    apart_m = segments_apart(view.position, target, seen.starts, seen.ends)
    return max(0.0, float(apart_m.min()) - mission.robot_radius_m)


def _past_hulls(view: View, robots: Flags, mission: Mission) -> View:
    """The scan with each hit on a hull moved to the nearest place where the hull may hide an obstacle.

    A robot keeps epsilon, less mu0, from obstacles. So behind a hit on its hull there is none for at least
    the part of a tangent that lies within that distance of the hull.
    """
    radius_m = mission.robot_radius_m
    kept_m = radius_m + max(0.0, mission.epsilon_m - mission.mu0_m)
    past_m = view.ranges_m + math.sqrt(kept_m**2 - radius_m**2)
    return replace(view, ranges_m=np.where(robots, np.minimum(past_m, mission.range_m_max), view.ranges_m))
