"""Judges true poses of several fleets against each other, over the whole motion. Pure.

Rule 1: bodies move as in `clew.judge.poses`. All fleets of a run have one clock.
Rule 2: hulls of different fleets never touch.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import shapely

from clew.judge.poses import HERE, Finding, Least, at_the_same_instants, closest, least
from clew.judge.truth import Run, Scene

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


def judge_between(fleets: Mapping[str, tuple[Scene, Run]]) -> Between:
    """Judge the fleets of one run against each other."""
    bodies = [(name, robot) for name, (_, run) in fleets.items() for robot in run.poses]
    instants_s, ways = at_the_same_instants([fleets[name][1].poses[robot] for name, robot in bodies])
    near: list[Least] = []
    for (one, way), (other, its_way) in combinations(zip(bodies, ways, strict=True), 2):
        if one[0] == other[0]:
            continue
        seen, hulls_m = its_way - way, sum(fleets[name][0].radius_m for name, _ in (one, other))
        off_m = shapely.LineString(seen).distance(HERE.shape) - hulls_m
        if off_m <= 0.0 or not near or off_m < near[-1].distance_m:  # a contact, or the nearest so far
            what = " and ".join(f"robot {robot} of {name}" for name, robot in (one, other))
            near.append(closest(instants_s, seen, HERE, hulls_m=hulls_m, what=what))
    contacts = tuple(str(each) for each in near if each.distance_m <= 0.0)
    return Between(nearest=least(near), contacts=contacts)


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
