"""Whether the second judge agrees with a verdict. Pure.

Rule 1: the least distances are the same, whether or not a promise was broken.
Rule 2: a verdict says nothing better than true poses do. It may say worse, of what poses do not show.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from clew.judge.poses import CLEARANCE, SEPARATION, Finding, Least

APART_M = 1e-5  # an ellipse is a polygon here, and an iteration in the first judge


def disagreements(finding: Finding, verdict: Mapping[str, Any]) -> Iterator[str]:
    """In what `verdict.json` differs from true poses."""
    lengths: dict[str, Least | None] = {
        "clearance_m_min": finding.clearance,
        "moving_clearance_m_min": finding.moving_clearance,
        "separation_m_min": finding.separation,
    }
    if not verdict["ok"] and all(verdict[name] is None for name in lengths):
        return  # a failed run that nobody could judge
    for name, least in lengths.items():
        said_m = verdict[name]
        if (least is None) != (said_m is None) or (least and abs(least.distance_m - said_m) > APART_M):
            yield f"{name} is {said_m}, by true poses {least}"
    yield from _miscounted(finding, verdict["violations_by_invariant"])
    if verdict["ok"]:
        yield from (f"ok, by true poses {each}" for each in finding.missed)
    if verdict["goal_reached"] and not finding.reached:
        yield "goal_reached, by true poses nobody ever was at the goal"
    if verdict["robots_arrived"] > len(finding.chain):
        yield f"robots_arrived is {verdict['robots_arrived']}, by true poses {len(finding.chain)}"


def _miscounted(finding: Finding, counts: Mapping[str, int]) -> Iterator[str]:
    """In which promises they differ."""
    for promise, count in counts.items():
        broken = [each for each in finding.broken if each.startswith(f"{promise} ")]
        if broken and not count:
            named, _, how = broken[0].partition(": ")
            yield f"{named} counts as kept, by true poses {how}"
        for each in (CLEARANCE, SEPARATION):
            if each.startswith(promise) and count and not broken:
                yield f"{each} counts as broken, by true poses it is not"
