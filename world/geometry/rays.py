"""Exact ray casting at obstacles and bodies [m, rad; world frame]."""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from protocol.arrays import Flags, Floats, Indices
from world.geometry.ellipses import unit_vectors
from world.geometry.rings import winding
from world.geometry.shapes import Ground

NearDiscs = Callable[[Floats, float], Floats]
"""The discs, x, y, radius (k, 3), that reach so near to a place (2,) at this instant."""

TOUCHING_M = 1e-9  # nearer than this to a rim counts as on it: rounding of metres
GRAZING_RAD = 1e-6  # above the rounding error of an arc sine near 1: the square root of a double's last bit


def cast(
    ground: Ground,
    origin_in_world: Floats,
    bearings_rad: Floats,
    *,
    range_m_max: float,
    discs: Floats,
) -> Floats:
    """The range of each ray: that of its first hit, or `range_m_max` without a hit.

    Args:
        ground: the obstacles.
        origin_in_world: `(2,)`; inside a shape every range is 0.
        bearings_rad: `(m,)`, in [-pi, pi].
        range_m_max: the range limit.
        discs: hulls of other bodies, `(k, 3)`: x, y, radius. Radius 0 is a point: no ray hits it.
    """
    hulls = discs[(discs[:, 2] > 0.0) & are_near(discs, origin_in_world, range_m_max)]
    # A circle is an ellipse with equal axes; the rotation does not matter.
    round_shapes = np.vstack(
        [ground.ellipses] + [np.column_stack((c, c[:, 2], np.zeros(len(c)))) for c in (ground.circles, hulls)]
    )
    rays = _rays_in(bearings_rad.tobytes())
    ranges_m = np.minimum(
        _cast_at_ellipses(round_shapes, origin_in_world, rays, range_m_max=range_m_max),
        _cast_at_edges(ground, origin_in_world, rays, range_m_max=range_m_max),
    )
    return np.minimum(ranges_m, range_m_max)


class _Rays(NamedTuple):
    """What all scans with the same directions share."""

    cosine: Floats
    sine: Floats
    order: Indices
    """The rays by bearing."""
    twice_round_rad: Floats
    """The bearings in that order, for two turns."""


@lru_cache(maxsize=8)  # the sizes of scans in a run: a revolution, and closer looks
def _rays_in(bearings: bytes) -> _Rays:
    bearings_rad = np.frombuffer(bearings)
    order = np.argsort(bearings_rad)
    twice_round_rad = np.concatenate((bearings_rad[order], bearings_rad[order] + math.tau))
    return _Rays(np.cos(bearings_rad), np.sin(bearings_rad), order, twice_round_rad)


def are_near(discs: Floats, place_m: Floats, within_m: float) -> Flags:
    """Which discs, x, y, radius (k, 3), reach so near to a place (2,); no ray of this range hits another."""
    return _reaches(place_m - discs[:, :2], discs[:, 2], within_m)


def _reaches(offsets: Floats, radii_m: Floats, range_m_max: float) -> Flags:
    return np.asarray(np.hypot(offsets[:, 0], offsets[:, 1]) - radii_m <= range_m_max)


def _cast_at_ellipses(ellipses: Floats, origin: Floats, rays: _Rays, *, range_m_max: float) -> Floats:
    offsets, radii_m = origin - ellipses[:, :2], ellipses[:, 2:4].max(axis=1, initial=0.0)
    near = _reaches(offsets, radii_m, range_m_max)
    rows, offsets = ellipses[near], offsets[near]
    each, ray = _in_sight(-offsets, radii_m[near], rays)
    # The unit frame is a linear map of the world frame, so lengths along a ray are metres in both.
    x, y = (across[each] for across in unit_vectors(rows, offsets[:, 0], offsets[:, 1]))
    dx, dy = unit_vectors(rows[each], rays.cosine[ray], rays.sine[ray])
    squares = dx * dx + dy * dy
    middle_m = -(x * dx + y * dy) / squares  # the point of the ray's line that is nearest to the centre
    half_chord_squared = 1.0 - (x + middle_m * dx) ** 2 - (y + middle_m * dy) ** 2
    half_chord_m = np.sqrt(np.maximum(half_chord_squared, 0.0) / squares)
    hit = (half_chord_squared >= 0.0) & (middle_m > 0.0)
    ranges_m = np.where(hit, np.maximum(middle_m - half_chord_m, 0.0), math.inf)
    ranges_m = np.where(x * x + y * y <= 1.0, 0.0, ranges_m)
    first_m = np.full(len(rays.order), math.inf)
    np.minimum.at(first_m, ray, ranges_m)
    return first_m


def _cast_at_edges(ground: Ground, origin: Floats, rays: _Rays, *, range_m_max: float) -> Floats:
    edges, (middles, half_lengths_m) = ground.edges, ground.edge_middles
    first_m = np.full(len(rays.order), math.inf)
    if len(edges) == 0:
        return first_m
    if winding(edges, origin[None])[2].sum() != 0.0:
        return np.zeros_like(rays.cosine)
    offsets = middles - origin
    near = _reaches(offsets, half_lengths_m, range_m_max + TOUCHING_M)
    edges = edges[near]
    edge, ray = _in_sight(offsets[near], half_lengths_m[near], rays)
    cosine, sine = rays.cosine[ray], rays.sine[ray]
    x, y = (edges[:, 0::2] - origin[0]).T, (edges[:, 1::2] - origin[1]).T
    beside_m = y[:, edge] * cosine - x[:, edge] * sine  # (2, p): both ends, across the ray
    # Neighbouring edges get the same number for their common vertex, so no ray passes between them.
    straddles = beside_m[0] * beside_m[1] <= 0.0
    edge, ray, beside_m = edge[straddles], ray[straddles], beside_m[:, straddles]
    along_m = x[:, edge] * cosine[straddles] + y[:, edge] * sine[straddles]
    run = beside_m[0] - beside_m[1]
    share = beside_m[0] / np.where(run == 0.0, 1.0, run)  # for an edge along the ray, its first end counts
    ranges_m = along_m[0] + share * (along_m[1] - along_m[0])
    np.minimum.at(first_m, ray, np.where(ranges_m >= 0.0, ranges_m, math.inf))
    return first_m


def _in_sight(centres: Floats, radii_m: Floats, rays: _Rays) -> tuple[Indices, Indices]:
    """The pairs of disc and ray that may meet: index of disc, index of ray.

    A distant disc covers few directions. For an origin in a disc, or on its rim, it covers all.
    """
    off_m = np.hypot(centres[:, 0], centres[:, 1])
    outside = off_m > radii_m + TOUCHING_M
    sine = np.where(outside, radii_m, 0.0) / np.where(outside, off_m, 1.0)
    half_rad = np.where(outside, np.arcsin(sine) + GRAZING_RAD, math.pi)
    low_rad = np.arctan2(centres[:, 1], centres[:, 0]) - half_rad
    low_rad = np.where(low_rad < -math.pi, low_rad + math.tau, low_rad)
    order, twice_round_rad = rays.order, rays.twice_round_rad
    first = np.searchsorted(twice_round_rad, low_rad)
    beyond = np.searchsorted(twice_round_rad, low_rad + 2.0 * half_rad, side="right")
    counts = np.minimum(beyond - first, len(order))
    place = np.arange(counts.sum()) + np.repeat(first - (np.cumsum(counts) - counts), counts)
    return np.repeat(np.arange(len(counts)), counts), order[place % len(order)]


def noisy(
    ranges_m: Floats, generator: Generator, *, sigma_m: float, error_m_max: float, range_m_max: float
) -> Floats:
    """Ranges as a sensor measures them: each hit has a Gaussian error, clipped at `error_m_max`."""
    errors_m = np.clip(generator.normal(0.0, sigma_m, ranges_m.shape), -error_m_max, error_m_max)
    read_m = np.clip(ranges_m + errors_m, 0.0, range_m_max)
    return np.where(ranges_m < range_m_max, read_m, range_m_max)
