"""Judges true poses against a scene, over the whole motion. Pure.

Rule 1: a body moves straight at constant speed between two samples. So its way is a polyline, and so is its
        way as seen from another body or a moving obstacle: the least distance is that of a polyline.
Rule 2: hulls keep `clearance_m` from obstacles and `separation_m` from each other, stay inside the bounds,
        and touch no moving obstacle while they drive themselves. Contact always breaks a promise.
Rule 3: the fleet has arrived when a body stands at the goal, and the others stand in one chain behind it.
        Robots that were killed or frozen on purpose need not.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from clew.judge.truth import Floats, Obstacle, Run, Scene

Flags = NDArray[np.bool_]

CLEARANCE, SEPARATION, ORDERS = (
    "S1 (clearance)",
    "S2 (separation)",
    "S3 (orders)",
)  # as docs/verdict.md has them
ROUNDING_M = 1e-6  # of poses and of shapely; a hundredth of the least tolerance of any scenario of ours


@dataclass(frozen=True, kw_only=True)
class Least:
    """A least distance between hulls, or of a hull from an obstacle."""

    distance_m: float
    t_s: float
    what: str

    def __str__(self) -> str:
        return f"{self.what}: {self.distance_m:.4f} m at t={self.t_s:.2f} s"


@dataclass(frozen=True, kw_only=True)
class Finding:
    """What true poses show."""

    clearance: Least | None
    """None: there is nothing to keep clear of."""
    moving_clearance: Least | None
    """Of hulls that drive."""
    separation: Least | None
    goal_m: float | None
    """How near to the goal the nearest body stands at the end; None: there is no goal."""
    reached: bool
    """Whether a body was at the goal at any time."""
    places_m: dict[int, tuple[float, float]]
    """Where each body stands at the end."""
    chain: tuple[int, ...]
    """Who stands in one chain from the goal on, nearest first; without a goal, the longest chain."""
    broken: tuple[str, ...]
    """Broken promises, each after its code and its name."""
    missed: tuple[str, ...]
    """What is lacking for an arrival."""

    @property
    def ok(self) -> bool:
        """Whether every promise was kept, and the fleet arrived."""
        return not self.broken and not self.missed


def judge(scene: Scene, run: Run) -> Finding:
    """Judge a run."""
    tracks = [each.track[:, 0] for each in scene.movers if each.track is not None]
    instants_s = np.unique(np.concatenate([*(rows[:, 0] for rows in run.poses.values()), *tracks, [0.0]]))
    ways = {robot: _at(rows, instants_s) for robot, rows in run.poses.items()}
    clearance = _least(_clearance(scene, robot, rows) for robot, rows in run.poses.items())
    separation = _least(_separation(scene, instants_s, ways, *pair) for pair in combinations(ways, 2))
    moving = _least(
        _moving_clearance(scene, instants_s, robot, way, mover)
        for robot, way in ways.items()
        for mover in scene.movers
    )
    broken = [
        *_is_broken(CLEARANCE, clearance, scene.clearance_m),
        *_is_broken(CLEARANCE, moving, 0.0),
        *_is_broken(SEPARATION, separation, scene.separation_m),
        *_outside(scene, run),
        *_jumps(scene, run),
    ]
    places_m = {robot: (float(rows[-1, 1]), float(rows[-1, 2])) for robot, rows in run.poses.items()}
    goal_m, chain = _chain(scene, run.harmed, places_m)
    return Finding(
        clearance=clearance,
        moving_clearance=moving,
        separation=separation,
        goal_m=goal_m,
        reached=scene.goal_m is None
        or any(_was_there(scene.goal_m, scene, rows) for rows in run.poses.values()),
        places_m=places_m,
        chain=chain,
        broken=tuple(broken),
        missed=tuple(_missed(scene, run, goal_m, chain)),
    )


def _least(found: Iterable[Least | None]) -> Least | None:
    return min((each for each in found if each), key=lambda each: each.distance_m, default=None)


def _at(rows: Floats, instants_s: Floats) -> Floats:
    """The places at these instants."""
    return np.stack([np.interp(instants_s, rows[:, 0], rows[:, column]) for column in (1, 2)], axis=1)


def _approach(way: Floats, shape: shapely.Geometry, drives: Flags | None = None) -> tuple[float, int, float]:
    """The least distance of a way from a shape, the leg that comes so near, and the share of the leg by then.

    Args:
        way: places, (n, 2).
        shape: where nothing may come near.
        drives: the legs that count, (n - 1,); None: all.
    """
    legs = shapely.linestrings(np.stack([way[:-1], way[1:]], axis=1))
    legs_m = np.where(True if drives is None else drives, shapely.distance(legs, shape), math.inf)
    leg = int(legs_m.argmin())
    line = shapely.shortest_line(legs[leg], shape)
    length_m = math.dist(way[leg], way[leg + 1])
    share = math.dist(way[leg], line.coords[0]) / length_m if length_m > 0.0 else 0.0
    return float(legs_m[leg]), leg, share


def _then(instants_s: Floats, leg: int, share: float) -> float:
    return float(instants_s[leg] + share * (instants_s[leg + 1] - instants_s[leg]))


def _stretched(rows: Floats) -> Floats:
    """At least two rows, so that there is a leg."""
    return rows if len(rows) > 1 else np.concatenate([rows, rows])


def _clearance(scene: Scene, robot: int, rows: Floats) -> Least | None:
    """The least clearance of a hull from what never moves."""
    rows, nearest, least_m = _stretched(rows), None, math.inf
    way = shapely.LineString(rows[:, 1:])
    for each in scene.obstacles:
        off_m = max(way.distance(each.shape) - each.radius_m, 0.0)
        if off_m < least_m:
            nearest, least_m = each, off_m
    if nearest is None:
        return None
    _, leg, share = _approach(rows[:, 1:], nearest.shape)
    t_s = _then(rows[:, 0], leg, share)
    return Least(distance_m=least_m - scene.radius_m, t_s=t_s, what=f"robot {robot} and {nearest.name}")


def _separation(
    scene: Scene, instants_s: Floats, ways: dict[int, Floats], one: int, other: int
) -> Least | None:
    """The least distance between two hulls: of the way of one, seen from the other, from where it stands."""
    instants_s, seen = _stretched(instants_s), _stretched(ways[other] - ways[one])
    apart_m, leg, share = _approach(seen, shapely.Point(0.0, 0.0))
    what = f"robots {one} and {other}"
    return Least(distance_m=apart_m - 2.0 * scene.radius_m, t_s=_then(instants_s, leg, share), what=what)


def _moving_clearance(
    scene: Scene, instants_s: Floats, robot: int, way: Floats, mover: Obstacle
) -> Least | None:
    """The same of a hull and a moving obstacle, while the hull drives."""
    assert mover.track is not None, "moving obstacles have tracks"
    drives = (np.diff(way, axis=0) != 0.0).any(axis=1)
    if not drives.any():
        return None
    off_m, leg, share = _approach(way - _at(mover.track, instants_s), mover.shape, drives)
    off_m = max(off_m - mover.radius_m, 0.0) - scene.radius_m
    return Least(distance_m=off_m, t_s=_then(instants_s, leg, share), what=f"robot {robot} and {mover.name}")


def _is_broken(promise: str, least: Least | None, required_m: float) -> Iterator[str]:
    if least is not None and (least.distance_m <= 0.0 or least.distance_m < required_m - ROUNDING_M):
        yield f"{promise}: {least}, required {required_m:.4f} m"


def _outside(scene: Scene, run: Run) -> Iterator[str]:
    if scene.bounds is None:
        return
    low, high = np.array(scene.bounds[:2]), np.array(scene.bounds[2:])
    for robot, rows in run.poses.items():
        inside_m = np.minimum(rows[:, 1:] - low, high - rows[:, 1:]).min(axis=1) - scene.radius_m
        if inside_m.min() < -ROUNDING_M:
            out_m, t_s = -inside_m.min(), rows[inside_m.argmin(), 0]
            yield f"{CLEARANCE}: robot {robot} is {out_m:.4f} m out of bounds at t={t_s:.2f} s"


def _jumps(scene: Scene, run: Run) -> Iterator[str]:
    """Between samples nothing is known of a body that is elsewhere sooner than it can be."""
    for robot, rows in run.poses.items():
        legs_s, legs_m = np.diff(rows[:, 0]), np.hypot(*np.diff(rows[:, 1:], axis=0).T)
        for leg in np.flatnonzero(legs_m > scene.speed_mps_max * legs_s + ROUNDING_M)[:1].tolist():
            yield f"{ORDERS}: robot {robot} jumps {legs_m[leg]:.4f} m at t={rows[leg, 0]:.2f} s"


def _chain(
    scene: Scene, harmed: frozenset[int], places_m: dict[int, tuple[float, float]]
) -> tuple[float | None, tuple[int, ...]]:
    """How near to the goal somebody stands, and the chain from there on with most robots that nobody harmed.

    The nearest may be dead, and others stand in a chain of their own, within the goal's tolerance, too.
    """
    goal_m = scene.goal_m
    off_m = {robot: 0.0 if goal_m is None else math.dist(at, goal_m) for robot, at in places_m.items()}
    heads = [robot for robot in places_m if off_m[robot] <= scene.goal_m_max + ROUNDING_M]
    chains = [_chain_from(scene, places_m, head) for head in heads]
    longest = max(chains, key=lambda chain: (len(set(chain) - harmed), len(chain)), default=())
    return None if goal_m is None else min(off_m.values(), default=math.inf), longest


def _was_there(goal_m: tuple[float, float], scene: Scene, rows: Floats) -> bool:
    return bool(np.hypot(*(rows[:, 1:] - goal_m).T).min() <= scene.goal_m_max + ROUNDING_M)


def _chain_from(scene: Scene, places_m: dict[int, tuple[float, float]], head: int) -> tuple[int, ...]:
    chain = [head]
    for ahead in chain:  # it grows meanwhile
        behind = [
            robot
            for robot in places_m
            if robot not in chain and math.dist(places_m[robot], places_m[ahead]) <= scene.behind_m_max
        ]
        chain += sorted(behind, key=lambda robot: math.dist(places_m[robot], places_m[ahead]))
    return tuple(chain)


def _missed(scene: Scene, run: Run, goal_m: float | None, chain: tuple[int, ...]) -> Iterator[str]:
    if not run.poses:
        yield "no body was ever placed"
    elif not chain:
        yield f"nobody stands at the goal: {goal_m:.4f} m from it, at most {scene.goal_m_max:.4f} m"
    else:
        for robot in sorted(set(run.poses) - set(chain) - run.harmed):
            yield f"robot {robot} stands in no chain behind the robot at the goal, and nobody harmed it"
