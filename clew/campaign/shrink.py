"""Reduces the fault plan of a failing run to the smallest one that still fails in the same way (`failures`).

Rule 1: rules keep their names, and so their random draws: a smaller plan injects a subset of the faults.
Rule 2: remove rules first, in halves, then one by one. Then reduce windows and counts. Then remove robots,
        also from rules. Repeat until nothing can be removed.
"""

import dataclasses
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from msgspec.structs import replace

from clew.campaign.failures import Case
from protocol.faults.fit import misfits
from protocol.faults.plan import Plan
from protocol.faults.rules import Burst, MessageRule, Partition, Rule
from protocol.frames import ROBOTS_MAX
from protocol.keys import robot_name

T = TypeVar("T")

WINDOW_S_MIN = 0.2  # two odometry periods: narrower windows do not explain more
HALVES_MAX = 12


def shrink(case: Case, fails: Callable[[Case], bool]) -> Case:
    """The smallest case found for which `fails` is still true."""
    while True:
        smaller = _with_fewer_robots(_with_smaller_rules(_with_fewer_rules(case, fails), fails), fails)
        if smaller == case:
            return case
        case = smaller


def _with_rules(case: Case, rules: Sequence[Rule]) -> Case:
    return dataclasses.replace(case, plan=replace(case.plan, rules=tuple(rules)))


def fewest(items: Sequence[T], fails: Callable[[list[T]], bool]) -> list[T]:
    """Delta debugging: leave out smaller and smaller parts, until nothing more can be left out."""
    kept = list(items)
    size = max(len(kept) // 2, 1)
    while size > 0:
        before = len(kept)
        for first in range(before - size, -1, -size):
            without = kept[:first] + kept[first + size :]
            if fails(without):
                kept = without
        if len(kept) == before:
            size //= 2
    return kept


def _with_fewer_rules(case: Case, fails: Callable[[Case], bool]) -> Case:
    return _with_rules(case, fewest(case.plan.rules, lambda rules: fails(_with_rules(case, rules))))


def _with_smaller_rules(case: Case, fails: Callable[[Case], bool]) -> Case:
    for place in range(len(case.plan.rules)):
        for _ in range(HALVES_MAX):
            rules = list(case.plan.rules)
            for rule in _smaller(rules[place], case.scenario.time.time_s_max):
                smaller = _with_rules(case, [*rules[:place], rule, *rules[place + 1 :]])
                if fails(smaller):
                    case = smaller
                    break
            else:
                break
    return case


def _with_fewer_robots(case: Case, fails: Callable[[Case], bool]) -> Case:
    while (robots := case.scenario.fleet.robots) > 1:
        fleet = replace(case.scenario.fleet, robots=robots - 1)
        plan = _without(case.plan, robot_name(robots))
        smaller = dataclasses.replace(case, scenario=replace(case.scenario, fleet=fleet), plan=plan)
        if not fails(smaller):
            break
        case = smaller
    return case


def _without(plan: Plan, robot: str) -> Plan:
    """The plan for a fleet without this robot."""
    left = (_left_of(rule, robot) for rule in plan.rules)
    return replace(plan, rules=tuple(rule for rule in left if rule is not None))


def _left_of(rule: Rule, robot: str) -> Rule | None:
    """A rule without this robot; None: a rule for messages that named no other, or now matches none."""
    if not isinstance(rule, MessageRule):
        return rule
    names = ["sender", "receiver", *(["group", "others"] if isinstance(rule, Partition) else [])]
    lists = {name: getattr(rule, name) for name in names}
    left = {name: tuple(each for each in lists[name] if each != robot) for name in names}
    if any(lists[name] and not left[name] for name in names):
        return None
    smaller = replace(rule, **left)
    return None if any(misfits(smaller, robots=ROBOTS_MAX)) else smaller


def _smaller(rule: Rule, time_s_max: float) -> Iterator[Rule]:
    """Weaker variants of a rule, the largest reductions first."""
    yield from _narrower(rule, time_s_max)
    if isinstance(rule, MessageRule):
        yield from _milder(rule)
    for name in ("robots", "occurrence", "copies", "bits"):
        if (count := getattr(rule, name, 1)) > 1:
            yield replace(rule, **{name: count // 2})
    for name in ("delay_s", "delay_s_max", "hold_s", "for_s", "after_s"):
        if (length_s := getattr(rule, name, None)) is not None and length_s > WINDOW_S_MIN:
            yield from _if_valid(rule, **{name: round(length_s / 2.0, 3)})


def _narrower(rule: Rule, time_s_max: float) -> Iterator[Rule]:
    """The rule with the first or second half of its window."""
    until_s = time_s_max if rule.until_s is None else rule.until_s
    if until_s - rule.from_s > WINDOW_S_MIN:
        middle_s = round((rule.from_s + until_s) / 2.0, 3)
        yield from _if_valid(rule, until_s=middle_s)
        yield from _if_valid(rule, from_s=middle_s)


def _milder(rule: MessageRule) -> Iterator[Rule]:
    if len(rule.kinds) > 1:
        yield from (replace(rule, kinds=(kind,)) for kind in rule.kinds)
    if isinstance(rule.burst, Burst):
        yield replace(rule, burst=replace(rule.burst, loss=rule.burst.loss / 2.0))
    elif rule.probability > 0.02:
        yield replace(rule, probability=round(rule.probability / 2.0, 3))


def _if_valid(rule: Rule, **changes: object) -> Iterator[Rule]:
    """The changed rule, if it is valid."""
    try:
        yield replace(rule, **changes)
    except ValueError:
        return
