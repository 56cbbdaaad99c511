"""Whether the second judge agrees with a verdict. Pure.

Rule 1: the least distances are the same, whether or not a promise was broken.
Rule 2: a verdict says nothing better than true poses do. It may say worse, of what poses do not show.
"""

from collections.abc import Iterator, Mapping
from typing import Any

from clew.judge.poses import CLEARANCE, ORDERS, SEPARATION, Finding, Least

Verdict = Mapping[str, Any]
APART_M = 1e-5  # an ellipse is a polygon here, and an iteration in the first judge
LEAST = ("clearance", "moving_clearance", "separation")


def disagreements(finding: Finding, verdict: Verdict) -> Iterator[str]:
    """In what `verdict.json` differs from true poses."""
    if not verdict["ok"] and all(verdict[f"{name}_m_min"] is None for name in LEAST):
        return  # a failed run that nobody could judge
    for name in LEAST:
        yield from _differs(f"{name}_m_min", verdict, getattr(finding, name))
    for promise in (CLEARANCE, SEPARATION, ORDERS):
        count = verdict["violations_by_invariant"].get(promise[:2])
        broken = [each for each in finding.broken if each.startswith(promise)]
        if broken and not count:
            yield f"{promise} counts as kept, by true poses {broken[0].partition(': ')[2]}"
        if count and not broken and promise != ORDERS:
            yield f"{promise} counts as broken, by true poses it is not"
    if verdict["ok"]:
        yield from (f"ok, by true poses {each}" for each in finding.missed)
    if verdict["goal_reached"] and not finding.reached:
        yield "goal_reached, by true poses nobody ever was at the goal"
    if verdict["robots_arrived"] > len(finding.in_place):
        yield f"robots_arrived is {verdict['robots_arrived']}, by true poses {len(finding.in_place)}"


def differences(near: list[Least], findings: Mapping[str, Finding], verdict: Verdict) -> Iterator[str]:
    """In what `verdict.json` of a run with several fleets differs from true poses."""
    if not verdict["ok"] and verdict["sim_s"] == 0.0:
        return  # likewise: it measured the starts alone
    contacts = [each for each in near if each.distance_m <= 0.0]
    yield from _differs("between_m_min", verdict, near[0] if near else None)
    if bool(contacts) != bool(verdict["contact_count"]):
        yield f"contact_count is {verdict['contact_count']}, by true poses {len(contacts)}"
    if verdict["fleets"].keys() != findings.keys():
        yield f"fleets are {', '.join(verdict['fleets'])}, by their folders {', '.join(findings)}"
    if verdict["ok"]:
        yield from (f"ok, by true poses {each}" for each in contacts)
        yield from (f"ok, by true poses not {name}" for name, each in findings.items() if not each.ok)


def _differs(name: str, verdict: Verdict, least: Least | None) -> Iterator[str]:
    said_m = verdict[name]
    if (least is None) != (said_m is None) or (least and abs(least.distance_m - said_m) > APART_M):
        yield f"{name} is {said_m}, by true poses {least}"
