"""Where all the other robots stand while one joins, and the places at the end of the strand. Pure."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from agents.membership.legs import on_ways
from agents.navigation.leg import certain_clearance_m_min
from protocol.arrays import Flags, Floats, distances_to_segments, segments_apart, unit_vectors
from protocol.legs import PLACE_SLACK_M, legs_m
from protocol.mission import Mission
from protocol.sweep import TOUCHING_M

BEARINGS = 72  # of places tried around the robot ahead: 9 cm apart at 1 m, as fine as what the leg keeps
BEARINGS_RAD = 2.0 * np.pi * np.arange(BEARINGS) / BEARINGS
HIT_M = 0.002  # of a grid: hits in one square of it are remembered as one, in its middle
HIT_OFF_M = HIT_M / math.sqrt(2.0)  # a hit is at most so far from where it is remembered
HULL_CORNERS = 16  # a hull's outline for the grid: off by 2 % of its radius


@dataclass(frozen=True)
class Stands:
    """Where all the other robots stand [m; world frame]."""

    strand: Floats
    """Those in place (k, 2), leader first; k >= 1."""
    waiting: Floats
    """Those that are not (m, 2)."""
    line: Floats
    """The way from the leader to the last of them (n, 2)."""
    last_leg: int
    """How many segments of that are the last robot's own leg."""

    @property
    def all(self) -> Floats:
        """Everybody (k + m, 2)."""
        return np.concatenate([self.strand, self.waiting])

    def admit(self, places: Floats, keep_m: float) -> Flags:
        """Which places (n, 2) would do for the next robot: apart from all, and the strand not folded back.

        Its leg ends where the robot ahead stands, so it need not be further off anything than that one is.
        """
        ahead = self.strand[-1]
        ends_at = np.broadcast_to(ahead, places.shape)
        starts, ends = self.line[:-1], self.line[1:]
        admitted = np.hypot(*(places - ahead).T) >= keep_m
        for robots in (self.waiting, self.strand[:1] if len(starts) else self.strand[:0]):
            least_m = np.minimum(keep_m, np.hypot(*(robots - ahead).T))
            off_m = distances_to_segments(robots, places[:, None], ends_at[:, None])
            admitted &= (off_m >= least_m - TOUCHING_M).all(axis=1)
        admitted &= (distances_to_segments(places[:, None], starts, ends) >= keep_m).all(axis=1)
        not_next = slice(0, len(starts) - self.last_leg)  # near to the leg that it begins at, it may be
        starts, ends = starts[not_next], ends[not_next]
        least_m = np.minimum(keep_m, distances_to_segments(ahead, starts, ends))
        apart_m = segments_apart(places[:, None], ends_at[:, None], starts, ends)
        return np.asarray(admitted & (apart_m >= least_m - TOUCHING_M).all(axis=1))


def outlines(robots: Floats, mission: Mission) -> Floats:
    """Points (m, 2) that keep a way as far from robots (n, 2) as the certificate will."""
    turns = 2.0 * np.pi * np.arange(HULL_CORNERS) / HULL_CORNERS
    radius_m = max(mission.robot_radius_m, mission.robot_keep_m - mission.obstacle_keep_m)
    return np.asarray((robots[:, None] + radius_m * unit_vectors(turns)).reshape(-1, 2))


def places_behind(stands: Stands, hits: Floats, mission: Mission) -> Floats:
    """The places (n, 2) around the last robot in place that would do, as far as hits (m, 2) are known."""
    ahead = stands.strand[-1]
    lengths = legs_m(mission)
    lines = ahead + lengths[:, None] * unit_vectors(BEARINGS_RAD)[:, None]
    keep_m = mission.robot_keep_m + PLACE_SLACK_M
    admitted = stands.admit(lines.reshape(-1, 2), keep_m).reshape(lines.shape[:2])
    some = [line[is_in] for line, is_in in zip(lines, admitted, strict=True) if is_in.any()]
    places = np.concatenate([np.empty((0, 2)), *_open_places(ahead, some, hits, mission)])
    others = np.concatenate([stands.strand[:-1], stands.waiting])
    reach_m = lengths.max(initial=0.0) + 2.0 * mission.robot_radius_m + mission.clear_m + PLACE_SLACK_M
    others = others[np.hypot(*(others - ahead).T) < reach_m]
    return places[~on_ways(outlines(others, mission), places, ahead, mission, slack_m=PLACE_SLACK_M)]


def _open_places(ahead: Floats, lines: Sequence[Floats], hits: Floats, mission: Mission) -> Iterator[Floats]:
    """Of the places (n, 2) in each line from `ahead` (2,), those with a leg to it that keeps off hits (m, 2).

    What the closest look may miss beside a hit lies along the ray to it, and one spacing beside it.
    """
    rays = mission.closest_rays
    spacing_rad, share = 2.0 * np.pi / rays, mission.sure_share_in(rays)
    least_m = mission.robot_radius_m + certain_clearance_m_min(mission) + HIT_OFF_M
    reach_m = mission.leg_m_max + mission.obstacle_keep_m + 1.0
    hits = hits[np.hypot(*(hits - ahead).T) < reach_m]
    hidden_m = mission.range_error_m_max + spacing_rad * (reach_m + mission.leg_m_max)
    # A hit at least this far from all legs of a line refuses none of them.
    far_m = (least_m + hidden_m) / share if share > 0.0 else np.inf
    x_m, y_m = (hits - ahead).T
    for line in lines:
        longest_m = float(np.hypot(*(line[-1] - ahead)))
        x, y = (line[-1] - ahead) / longest_m
        along_m, across_m = x * x_m + y * y_m, x * y_m - y * x_m
        near = hits[(np.abs(across_m) < far_m) & (along_m > -far_m) & (along_m < longest_m + far_m)]
        if len(near) == 0:
            yield line
            continue
        apart_m = np.hypot(*np.moveaxis(near[:, None] - line, -1, 0))
        off_m = distances_to_segments(near[:, None], line, ahead) * share - spacing_rad * apart_m
        yield line[off_m.min(axis=0, initial=np.inf) - mission.range_error_m_max >= least_m]
