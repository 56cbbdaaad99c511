"""Judges true poses against a scene, over the whole motion. Pure.

Rule 1: a body moves straight and evenly between two samples. So its way as seen from another one, or from an
        obstacle, is a polyline: the least distance is that of a polyline.
Rule 2: hulls keep `clearance_m` from obstacles and `separation_m` from each other, stay inside the bounds,
        and touch no moving obstacle while they drive themselves. Contact always breaks a promise.
Rule 3: the fleet has arrived when a body stands at the goal, and each other one stands in place behind those
        ahead of it. Robots that were killed or frozen on purpose need not.
Rule 4: in place, a robot has come up to the ground ahead: the place of the robot ahead, and the ways that the
        robots before it took from there on.
Rule 5: hulls of different fleets never touch. All fleets of a run have one clock.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np
import shapely

from clew.judge.truth import Floats, Solid, Truth

# As docs/verdict.md has them.
CLEARANCE, SEPARATION, ORDERS = "S1 (clearance)", "S2 (separation)", "S3 (orders)"
ROUNDING_M = 1e-6  # of poses and of shapely; a hundredth of the least tolerance of any scenario of ours


@dataclass(frozen=True, kw_only=True, order=True)
class Least:
    """A least distance between two solids, of which one is a hull."""

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
    """The robots that stand in place, from the goal on; without a goal, the longest chain."""
    in_place: frozenset[int]
    """The robots in any such chain: the head of another one may have died, unnoticed until the end."""
    broken: tuple[str, ...]
    """Broken promises, each after its code and its name."""
    missed: tuple[str, ...]
    """What is lacking for an arrival."""

    @property
    def ok(self) -> bool:
        """Whether every promise was kept, and the fleet arrived."""
        return not self.broken and not self.missed


def judge(truth: Truth) -> Finding:
    """Judge a run."""
    hulls = truth.robots.values()
    clearance = min(gaps(product(hulls, truth.obstacles)), default=None)
    moving = min(gaps(product(hulls, truth.movers), driving=True), default=None)
    separation = min(gaps(combinations(hulls, 2)), default=None)
    places = {robot: shapely.Point(hull.track[-1, 1:]) for robot, hull in truth.robots.items()}
    goal = shapely.Point(truth.goal_m or (0.0, 0.0))  # without one, all are there: `goal_m_max` is infinite
    goal_m = min(map(goal.distance, places.values()), default=math.inf)
    there_m = truth.goal_m_max + ROUNDING_M
    # The nearest may be dead, and others stand in a chain of their own, within the tolerance, too.
    chains = [_chain(truth, places, head) for head in places if goal.distance(places[head]) <= there_m]
    chain = max(chains, key=lambda each: (len(set(each) - truth.harmed), len(each)), default=())
    missed = [
        f"robot {robot} stands in no chain behind the robot at the goal, and nobody harmed it"
        for robot in places
        if robot not in {*chain, *truth.harmed}
    ]
    if not chain:
        missed = [f"nobody stands at the goal: {goal_m:.4f} m from it, at most {truth.goal_m_max:.4f} m"]
    missed += [f"robot {robot} has no pose" for robot in truth.unseen]
    return Finding(
        clearance=clearance,
        moving_clearance=moving,
        separation=separation,
        goal_m=goal_m if truth.goal_m else None,
        reached=any(goal.distance(_line(hull.track[:, 1:])) <= there_m for hull in hulls),
        places_m={robot: (place.x, place.y) for robot, place in places.items()},
        chain=chain,
        in_place=frozenset().union(*chains) if truth.goal_m else frozenset(chain),
        broken=(
            *_is_broken(CLEARANCE, clearance, truth.clearance_m),
            *_is_broken(CLEARANCE, moving, 0.0),
            *_is_broken(SEPARATION, separation, truth.separation_m),
            *(each for hull in hulls for each in _leaves(truth, hull)),
        ),
        missed=tuple(missed),
    )


def judge_between(fleets: Mapping[str, Truth]) -> list[Least]:
    """How near each two robots of different fleets came to each other, the nearest first."""
    named = [
        [replace(each, name=f"{each.name} of {name}") for each in truth.robots.values()]
        for name, truth in fleets.items()
    ]
    return sorted(gaps(pair for one, other in combinations(named, 2) for pair in product(one, other)))


def gaps(pairs: Iterable[tuple[Solid, Solid]], *, driving: bool = False) -> Iterator[Least]:
    """How near the two of each pair come to each other; where asked so, only while the first one drives."""
    for one, other in pairs:
        t_s = np.union1d(one.track[:, 0], other.track[:, 0])
        way, its_way = _places_at(t_s, one.track), _places_at(t_s, other.track)
        rows = np.column_stack([way - its_way, t_s])
        line: shapely.Geometry = _line(rows)
        if driving:
            legs = np.stack([rows[:-1], rows[1:]], axis=1)[(np.diff(way, axis=0) != 0.0).any(axis=1)]
            line = shapely.multilinestrings(shapely.linestrings(legs))
        if not line.is_empty:
            gap = shapely.shortest_line(line, other.shape)
            distance_m = max(gap.length - other.radius_m, 0.0) - (one.hull_m + other.hull_m)
            along_m = line.project(shapely.get_point(gap, 0)) - 1e-9  # where it comes to stand, not leaves
            at = line.interpolate(max(along_m, 0.0))  # its height is the time
            yield Least(distance_m=distance_m, t_s=at.z, what=f"{one.name} and {other.name}")


def _places_at(t_s: Floats, track: Floats) -> Floats:
    return np.stack([np.interp(t_s, track[:, 0], track[:, column]) for column in (1, 2)], axis=1)


def _line(rows: Floats) -> shapely.LineString:
    """The way through these places; it has a leg even where nothing moves."""
    return shapely.LineString(np.vstack([rows, rows[-1:]]))


def _is_broken(promise: str, found: Least | None, required_m: float) -> Iterator[str]:
    if found is not None and (found.distance_m <= 0.0 or found.distance_m < required_m - ROUNDING_M):
        yield f"{promise}: {found}, required {required_m:.4f} m"


def _leaves(truth: Truth, hull: Solid) -> Iterator[str]:
    """Where a hull is out of bounds, or its body sooner than it can be: nothing is known of what it did."""
    t_s, places = hull.track[:, 0], shapely.points(hull.track[:, 1:])
    if truth.bounds is not None:
        out_m = shapely.distance(places, shapely.box(*truth.bounds + hull.hull_m * np.array([1, 1, -1, -1])))
        if out_m.max() > ROUNDING_M:
            when_s = t_s[out_m.argmax()]
            yield f"{CLEARANCE}: {hull.name} is {out_m.max():.4f} m out of bounds at t={when_s:.2f} s"
    legs_m = shapely.distance(places[:-1], places[1:])
    for leg in np.flatnonzero(legs_m > truth.speed_mps_max * np.diff(t_s) + ROUNDING_M)[:1]:
        yield f"{ORDERS}: {hull.name} jumps {legs_m[leg]:.4f} m at t={t_s[leg]:.2f} s"


def _chain(truth: Truth, places: Mapping[int, shapely.Point], head: int) -> tuple[int, ...]:
    """The robot at the goal, and who stands in place behind it, behind that one and so on."""
    chain = [head]
    for number, ahead in enumerate(chain, start=1):  # it grows meanwhile
        ways = [truth.robots[each].track[:, 1:] for each in chain[:number]]
        ground = shapely.multilinestrings([_from_there_on(way, places[ahead], truth.drift_m) for way in ways])
        in_place = {robot for robot in places if ground.distance(places[robot]) <= truth.behind_m_max}
        chain += sorted(in_place - set(chain), key=lambda robot: places[ahead].distance(places[robot]))
    return tuple(chain)


def _from_there_on(way: Floats, place: shapely.Point, drift_m: float) -> shapely.LineString:
    """The way from where it last passed a place; if it began beyond, straight from there to its start."""
    off_m = np.hypot(*(way - place.coords[0]).T)
    last = int(np.flatnonzero(off_m <= off_m.min() + drift_m)[-1])
    return shapely.LineString(np.concatenate([place.coords, way[min(last + 1, len(way) - 1) :]]))
