"""Judges true poses of several fleets against each other, over the whole motion. Pure.

Rule 1: a body moves straight at constant speed between two samples, and stands after the last, as in
        `clew.judge.poses`. All fleets of a run have one clock.
Rule 2: hulls of different fleets never touch.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import shapely

from clew.judge.poses import Finding, Least
from clew.judge.truth import Floats, Run, Scene

APART_M = 1e-6
"""How much two judges may differ: the rounding of samples that a tick's straight line goes through."""


@dataclass(frozen=True, kw_only=True)
class Between:
    """What true poses show of several fleets."""

    nearest: Least | None
    """None: no two fleets have bodies."""
    contacts: tuple[str, ...]
    """Pairs of robots that touched."""

    @property
    def ok(self) -> bool:
        """Whether no two fleets touched."""
        return not self.contacts


@dataclass(frozen=True)
class _Body:
    what: str
    fleet: str
    radius_m: float
    way: Floats


def judge_between(fleets: Mapping[str, tuple[Scene, Run]]) -> Between:
    """Judge the fleets of one run against each other."""
    rows = [each for _, run in fleets.values() for each in run.poses.values()]
    instants_s = np.unique(np.concatenate([[0.0], *(each[:, 0] for each in rows)]))
    bodies = [
        _Body(f"robot {robot} of {name}", name, scene.radius_m, _way(poses, instants_s))
        for name, (scene, run) in fleets.items()
        for robot, poses in run.poses.items()
    ]
    nearest: Least | None = None
    contacts = []
    for one, other in combinations(bodies, 2):
        if one.fleet == other.fleet:
            continue
        seen, reach_m = other.way - one.way, one.radius_m + other.radius_m
        if _at_least_m(seen) - reach_m > max(0.0, math.inf if nearest is None else nearest.distance_m):
            continue
        found = _least(instants_s, seen, reach_m, f"{one.what} and {other.what}")
        if found.distance_m <= 0.0:
            contacts.append(str(found))
        if nearest is None or found.distance_m < nearest.distance_m:
            nearest = found
    return Between(nearest=nearest, contacts=tuple(contacts))


def _way(rows: Floats, instants_s: Floats) -> Floats:
    return np.stack([np.interp(instants_s, rows[:, 0], rows[:, column]) for column in (1, 2)], axis=1)


def _at_least_m(seen: Floats) -> float:
    """Less than this the way of one, as seen from the other, is never off it: quick, and too low."""
    legs_m = np.hypot(*np.diff(seen, axis=0).T).max(initial=0.0)
    return float(np.hypot(*seen.T).min() - legs_m / 2.0)


def _least(instants_s: Floats, seen: Floats, reach_m: float, what: str) -> Least:
    if len(seen) == 1:
        return Least(distance_m=float(np.hypot(*seen[0])) - reach_m, t_s=float(instants_s[0]), what=what)
    legs = shapely.linestrings(np.stack([seen[:-1], seen[1:]], axis=1))
    here = shapely.Point(0.0, 0.0)
    leg = int(shapely.distance(legs, here).argmin())
    line = shapely.shortest_line(legs[leg], here)
    length_m = math.dist(seen[leg], seen[leg + 1])
    share = math.dist(seen[leg], line.coords[0]) / length_m if length_m > 0.0 else 0.0
    t_s = float(instants_s[leg] + share * (instants_s[leg + 1] - instants_s[leg]))
    return Least(distance_m=line.length - reach_m, t_s=t_s, what=what)


def disagreements(
    between: Between, findings: Mapping[str, Finding], verdict: Mapping[str, Any]
) -> Iterator[str]:
    """In what `verdict.json` of a run with several fleets differs from true poses."""
    said_m, nearest = verdict["between_m_min"], between.nearest
    if nearest is None or abs(nearest.distance_m - said_m) > APART_M:
        yield f"between_m_min is {said_m}, by true poses {nearest}"
    if bool(between.contacts) != bool(verdict["contact_count"]):
        yield f"contact_count is {verdict['contact_count']}, by true poses {len(between.contacts)}"
    if verdict["fleets"].keys() != findings.keys():
        yield f"fleets are {', '.join(verdict['fleets'])}, by their folders {', '.join(findings)}"
    if verdict["ok"]:
        yield from (f"ok, by true poses {each}" for each in between.contacts)
        yield from (f"ok, by true poses not {name}" for name, each in findings.items() if not each.ok)
