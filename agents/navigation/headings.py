"""Which steps are worth a try: those that may cost less than one that is known, if they are certified.

Rule 1: the cost-to-go at a point is at least that of one of the four cells around it. So a step that ends at
        some cost ends within the diagonal of a cell of a cell with that cost or less.
Rule 2: a certified step ends where the scan has seen: no further off than the longer one of the two rays
        beside its heading, since the walls of the scan cross all headings.
Rule 3: both save time and decide nothing. In doubt a step is tried.
"""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from agents.navigation.guidance import CostToGo
from agents.navigation.scan import View
from protocol.arrays import Flags, Floats

BESIDE_CELLS = 1.5  # more than the diagonal of a cell, by far more than rounding
NEAR_CELLS = 20.0  # nearer cells count as seen: they lie beside too many rays


def may_cost_less(
    view: View, headings_rad: Floats, cost_to_go: CostToGo, cost_m: float
) -> tuple[Flags, float]:
    """The headings (h,) on which a certified step may end at this cost or less, and its least length [m]."""
    if math.isinf(cost_m):
        return np.ones(len(headings_rad), dtype=np.bool_), 0.0
    cell_m = cost_to_go.grid.cell_m
    beside_m = BESIDE_CELLS * cell_m
    reach_m = float(view.ranges_m.max()) + beside_m
    off = cost_to_go.places(cost_m, view.position, within_m=reach_m) - view.position
    off_m, bearings_rad = np.hypot(off[:, 0], off[:, 1]), np.arctan2(off[:, 1], off[:, 0])
    is_seen = off_m <= np.maximum(seen_m(view, bearings_rad) + beside_m, NEAR_CELLS * cell_m)
    off_m, bearings_rad = off_m[is_seen], bearings_rad[is_seen]
    half_rad = np.where(off_m > beside_m, np.arcsin(beside_m / np.maximum(off_m, beside_m)), math.pi)
    least_m = float(off_m.min(initial=math.inf)) - beside_m
    return _within(headings_rad, bearings_rad - half_rad, bearings_rad + half_rad), least_m


def seen_m(view: View, bearings_rad: Floats) -> Floats:
    """The longest range (n,) beside these directions, as wide as a cell is that is not near."""
    rays = len(view.ranges_m)
    spacing_rad = 2.0 * math.pi / rays
    beside = math.ceil(math.asin(BESIDE_CELLS / NEAR_CELLS) / spacing_rad) + 1  # and the ray to either side
    around_m = np.concatenate((view.ranges_m[-beside:], view.ranges_m, view.ranges_m[:beside]))
    longest_m = sliding_window_view(around_m, rays).max(axis=0)  # a row for each neighbour: fast
    return np.asarray(longest_m[np.rint((bearings_rad + math.pi) / spacing_rad).astype(np.intp) % rays])


def _within(angles_rad: Floats, low_rad: Floats, high_rad: Floats) -> Flags:
    """Whether each angle (h,), all in [-pi, pi], is in one of these intervals (n,), (n,)."""
    order = np.argsort(angles_rad)
    turns = np.concatenate([angles_rad[order] + turn * 2.0 * math.pi for turn in (-1, 0, 1)])
    opened = np.bincount(np.searchsorted(turns, low_rad), minlength=len(turns) + 1)
    closed = np.bincount(np.searchsorted(turns, high_rad, side="right"), minlength=len(turns) + 1)
    is_in = np.cumsum(opened - closed)[:-1].reshape(3, -1).any(axis=0)
    within = np.empty(len(order), dtype=np.bool_)
    within[order] = is_in
    return within
