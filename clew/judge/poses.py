"""Judges true poses against a scene, over the whole motion. Pure.

Rule 1: a body moves straight and evenly between two samples. So its way is a polyline, and so is its way as
        seen from another body or from a moving obstacle: the least distance is that of a polyline.
Rule 2: hulls keep `clearance_m` from obstacles and `separation_m` from each other, stay inside the bounds,
        and touch no moving obstacle while they drive themselves. Contact always breaks a promise.
Rule 3: the fleet has arrived when a body stands at the goal, and each other one stands in place behind those
        ahead of it. Robots that were killed or frozen on purpose need not.
Rule 4: in place, a robot has come up to the ground ahead: the place of the robot ahead, and the ways that the
        robots before it took from there on.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from clew.judge.truth import Floats, Obstacle, Run, Scene

# As docs/verdict.md has them.
CLEARANCE, SEPARATION, ORDERS = "S1 (clearance)", "S2 (separation)", "S3 (orders)"
ROUNDING_M = 1e-6  # of poses and of shapely; a hundredth of the least tolerance of any scenario of ours
Flags = NDArray[np.bool_]
HERE = Obstacle(name="", shape=shapely.Point(0.0, 0.0), radius_m=0.0, track=np.empty((0, 3)))


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
    """Who stands in place, from the goal on; without a goal, the longest chain."""
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
    radius_m, movers = scene.radius_m, scene.movers
    instants_s, each_way = at_the_same_instants([*run.poses.values(), *(each.track for each in movers)])
    ways = dict(zip(run.poses, each_way, strict=False))
    clearance = least(
        closest(instants_s, way, nearest, hulls_m=radius_m, what=f"robot {robot} and {nearest.name}")
        for robot, way in ways.items()
        for nearest in _nearest(scene, way)
    )
    moving = least(
        closest(
            instants_s,
            way - track,
            mover,
            hulls_m=radius_m,
            what=f"robot {robot} and {mover.name}",
            counts=drives,
        )
        for robot, way in ways.items()
        if (drives := (np.diff(way, axis=0) != 0.0).any(axis=1)).any()
        for mover, track in zip(movers, each_way[len(ways) :], strict=True)
    )
    separation = least(
        closest(instants_s, ways[b] - ways[a], HERE, hulls_m=2.0 * radius_m, what=f"robots {a} and {b}")
        for a, b in combinations(ways, 2)
    )
    broken = [
        *_is_broken(CLEARANCE, clearance, scene.clearance_m),
        *_is_broken(CLEARANCE, moving, 0.0),
        *_is_broken(SEPARATION, separation, scene.separation_m),
        *_outside(scene, run),
        *_jumps(scene, run),
    ]
    goal = shapely.Point(scene.goal_m) if scene.goal_m else None
    off_m = {robot: goal.distance(shapely.Point(way[-1])) if goal else 0.0 for robot, way in ways.items()}
    there_m = scene.goal_m_max + ROUNDING_M
    # The nearest may be dead, and others stand in a chain of their own, within the tolerance, too.
    chains = [_chain(scene, ways, robot) for robot in ways if off_m[robot] <= there_m]
    chain = max(chains, key=lambda each: (len(set(each) - run.harmed), len(each)), default=())
    goal_m = min(off_m.values(), default=math.inf) if goal else None
    return Finding(
        clearance=clearance,
        moving_clearance=moving,
        separation=separation,
        goal_m=goal_m,
        reached=any(not goal or goal.distance(shapely.LineString(way)) <= there_m for way in ways.values()),
        places_m={robot: (float(way[-1, 0]), float(way[-1, 1])) for robot, way in ways.items()},
        chain=chain,
        broken=tuple(broken),
        missed=tuple(_missed(scene, run, goal_m, chain)),
    )


def at_the_same_instants(tracks: Iterable[Floats]) -> tuple[Floats, list[Floats]]:
    """The instants of all tracks, and the places (n, 2) of each at them; it stands before and after."""
    tracks = list(tracks)
    instants_s = np.unique(np.concatenate([[0.0], *(rows[:, 0] for rows in tracks)]))
    instants_s = np.append(instants_s, instants_s[-1] + 1.0)  # there is a leg even where nothing moves
    return instants_s, [
        np.stack([np.interp(instants_s, rows[:, 0], rows[:, column]) for column in (1, 2)], axis=1)
        for rows in tracks
    ]


def closest(
    instants_s: Floats,
    way: Floats,
    thing: Obstacle,
    *,
    hulls_m: float,
    what: str,
    counts: Flags | None = None,
) -> Least:
    """The least distance on a way, as seen from what stands still there.

    Args:
        instants_s: when the way is where (n,).
        way: its places (n, 2).
        thing: what stands still.
        hulls_m: how much of the distance is hulls.
        what: what comes near to what.
        counts: the legs that count (n - 1,); None: all.
    """
    legs = shapely.linestrings(np.stack([way[:-1], way[1:]], axis=1))
    legs_m = shapely.distance(legs, thing.shape)
    if counts is not None:
        legs_m[~counts] = math.inf
    leg = int(legs_m.argmin())
    foot = shapely.shortest_line(legs[leg], thing.shape).coords[0]
    share = math.dist(way[leg], foot) / (legs[leg].length or 1.0)
    t_s = float(instants_s[leg] + share * (instants_s[leg + 1] - instants_s[leg]))
    return Least(distance_m=max(float(legs_m[leg]) - thing.radius_m, 0.0) - hulls_m, t_s=t_s, what=what)


def least(found: Iterable[Least]) -> Least | None:
    """The least of them."""
    return min(found, key=lambda each: each.distance_m, default=None)


def _nearest(scene: Scene, way: Floats) -> Iterator[Obstacle]:
    """The obstacle to which a way comes nearest, if there is one."""
    line = shapely.LineString(way)
    yield from sorted(scene.obstacles, key=lambda each: line.distance(each.shape) - each.radius_m)[:1]


def _is_broken(promise: str, found: Least | None, required_m: float) -> Iterator[str]:
    if found is not None and (found.distance_m <= 0.0 or found.distance_m < required_m - ROUNDING_M):
        yield f"{promise}: {found}, required {required_m:.4f} m"


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


def _chain(scene: Scene, ways: Mapping[int, Floats], head: int) -> tuple[int, ...]:
    """The robot at the goal, and who stands in place behind it, behind that one and so on."""
    places = {robot: shapely.Point(way[-1]) for robot, way in ways.items()}
    chain = [head]
    for number, ahead in enumerate(chain, start=1):  # it grows meanwhile
        ground = shapely.multilinestrings(
            [_from_there_on(ways[each], places[ahead], scene) for each in chain[:number]]
        )
        in_place = [robot for robot in ways if ground.distance(places[robot]) <= scene.behind_m_max]
        chain += sorted(set(in_place) - set(chain), key=lambda robot: places[ahead].distance(places[robot]))
    return tuple(chain)


def _from_there_on(way: Floats, place: shapely.Point, scene: Scene) -> shapely.LineString:
    """The way from where it last passed a place; if it began beyond, straight from there to its start."""
    off_m = np.hypot(*(way - place.coords[0]).T)
    last = int(np.flatnonzero(off_m <= off_m.min() + scene.drift_m)[-1])
    return shapely.LineString(np.concatenate([place.coords, way[min(last + 1, len(way) - 1) :]]))


def _missed(scene: Scene, run: Run, goal_m: float | None, chain: tuple[int, ...]) -> Iterator[str]:
    if not run.poses:
        yield "no body was ever placed"
    elif not chain:
        yield f"nobody stands at the goal: {goal_m:.4f} m from it, at most {scene.goal_m_max:.4f} m"
    else:
        for robot in sorted(set(run.poses) - set(chain) - run.harmed):
            yield f"robot {robot} stands in no chain behind the robot at the goal, and nobody harmed it"
