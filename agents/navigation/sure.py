"""What a scan is sure to have seen: how near to the sensor an obstacle can reach unseen between two rays.

Premises, which the loader checks against the world (`world/scenario/budget.py`):

Premise 1: no corner that a ray can meet is sharper than the mission's `sharpest_corner_rad`, here gamma, and
           gamma is 60 degrees at most where an obstacle has more than four corners.
Premise 2: within the range in use no obstacle fits between two rays, and no part of one between two of its
           edges that are no neighbours: its least way across, normal to an edge, is as long as the spacing.

Between two neighbouring rays from P, with hits A and B, let K be a connected part of an obstacle that lies in
the triangle P A B. It touches neither ray before its hit, else the hit would be there. By premise 2 it is no
whole obstacle, so it enters through the chord A B. If it has one corner T, its convex hull is a triangle on
that chord with T on top, both sides leave P A B through the chord, and T sees the chord at an angle of at
least gamma; so does every point of K, since all are in the triangle A B T. K may have several corners, each
blunter than gamma: a pointed arch of the least width, cut at its feet, has nowhere a shorter way across, and
sees its feet at 60 degrees from its tip. That nothing sees the chord at less than 60 degrees and gamma is
proved for obstacles without acute corners (`docs/navigation.md`), and was searched for others, as it was that
four corners need no such limit.

The place nearest to P from which A and B are seen at gamma is the apex over equal ranges: a hit that is moved
back along its ray, away from P, is seen at a smaller angle. So with m the nearer one of both ranges and s the
spacing of the rays,

    no point of K is nearer to P than  m * sin((gamma - s) / 2) / sin(gamma / 2).

Rule 1: what is nearer than that between two rays is free. This is a property of the ground there: it scales
        with the distance of the two hits, and it lies along the rays. Beside a wall that the rays graze it
        costs little, however sharp a corner is anywhere else.
Rule 2: a hit may be wrong by the range error, along its ray. A range-limit point counts as a hit.
Rule 3: rays from other places narrow that further (`agents/navigation/crossing.py`).
Rule 4: of a robot's body, a disc of radius r, gamma is a right angle. Where both rays hit it, less than half
        of it lies in the triangle P A B, and from the arc of such a part its chord is seen at a right angle
        or more. Where one passes it and the other is h from its middle, more than half may lie there, but
        reaches no nearer: r - sqrt(r^2 - h^2) <= (r + h) / 2. It fits between no two rays (premise 2).
Rule 5: nothing else is taken from the world: the bound holds with any shapes that keep both premises.
"""

from dataclasses import dataclass

import numpy as np

from agents.navigation.crossing import divided_m
from agents.navigation.scan import View
from protocol.arrays import Flags, Floats, of_next
from protocol.mission import Mission

LEAST_M = 1e-6  # so that a wall has a direction: at the sensor's own place it would forbid nothing
CLOSER = 4  # factor for the revolutions of a closer look: what two rays can hide is a quarter then


def closer(mission: Mission, rays: int) -> int | None:
    """The revolutions of a closer look than one with so many rays; None if there is no closer one."""
    revolutions = min(CLOSER * rays, mission.closest_rays) // mission.directions
    return revolutions if revolutions * mission.directions > rays else None


@dataclass(frozen=True)
class Sure:
    """The sure range in each gap between a ray and the next one, and where it ends [m; world frame]."""

    ranges_m: Floats
    """(n,); infinite where both rays are left out."""
    starts: Floats
    """Where it ends on the ray (n, 2)."""
    ends: Floats
    """Where it ends on the next ray (n, 2)."""


def sure(view: View, mission: Mission, *, leave_out: Flags | None = None, bodies_only: bool = False) -> Sure:
    """What a scan is sure of (rules 1 and 2), of all shapes or of robots' bodies only.

    A ray that is left out says nothing of the gaps beside it.
    """
    true_m = np.maximum(view.ranges_m - mission.range_error_m_max, 0.0)
    known_m = true_m if leave_out is None else np.where(leave_out, np.inf, true_m)
    nearer_m = np.minimum(known_m, of_next(known_m))
    is_told, share = np.isfinite(nearer_m), mission.sure_share_in(len(true_m), bodies_only=bodies_only)
    sure_m = np.maximum(share * np.where(is_told, nearer_m, 0.0), LEAST_M)
    ranges_m = np.where(is_told, sure_m, np.inf)
    for other in view.earlier:
        ranges_m = np.maximum(ranges_m, divided_m(view, true_m, other, mission.range_error_m_max))
    finite_m = np.where(np.isfinite(ranges_m), ranges_m, 0.0)[:, None]
    starts, ends = (view.position + finite_m * each for each in (view.rays, of_next(view.rays)))
    return Sure(ranges_m, starts, ends)
