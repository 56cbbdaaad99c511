"""Cuts the fault plan of a failing run down to the least that still fails in the same way.

Rule 1: in the same way means: the same invariant is broken first, or the same exception is raised, or the run
        ends in the same way, or fails to heal. What else is different does not matter.
Rule 2: rules keep their names, and so their draws: less of a plan is a part of what it did.
Rule 3: rules go first, in halves and then one by one; then windows and counts; then robots; and again, until
        nothing can go.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from msgspec.structs import replace

from lab.campaign_episode import OutOfTimeError, wall_clock_limit
from lab.liveness import unlively
from lab.rehearsal import Rehearsal
from lab.rehearse import EPOCH, verdict_on
from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.faults.rules import Burst, MessageRule, Rule
from protocol.timeline import RobotFailed
from world.scenario import Scenario

WINDOW_S_MIN = 0.2  # two odometries: narrower windows tell nobody more
HALVES_MAX = 12
WALL_S_MAX = 60.0  # for an episode of a third of a second: then it counts as one that has no end


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A run that fails, or part of one."""

    scenario: Scenario
    seed: int
    plan: Plan
    quiet_s: float | None = None
    """When the fleet has to be able to heal; None: it is not asked to."""
    outside: frozenset[int] = frozenset()


@dataclass(frozen=True, slots=True)
class Failure:
    """In which way a run failed, and what it said of it."""

    way: str
    reason: str


def failure_of(case: Case) -> Failure | None:
    """Rehearse the case; returns how it fails, or None where it does not."""
    try:
        with wall_clock_limit(WALL_S_MAX):
            rehearsal = Rehearsal(case.scenario, case.seed, case.plan).run()
    except OutOfTimeError:
        return Failure("has no end", f"it was not over after {WALL_S_MAX:g} s")
    except UsageError:
        return None  # there is no such run
    except Exception as error:
        return Failure(f"raises {type(error).__name__}", str(error))
    return _failure(case, rehearsal)


def _failure(case: Case, rehearsal: Rehearsal) -> Failure | None:
    verdict = verdict_on(rehearsal, case.seed, started_at=EPOCH, wall_s=0.0)
    records = (entry.record for _, entry in rehearsal.entries)
    failed = next((each.reason for each in records if isinstance(each, RobotFailed)), None)
    if failed is not None:
        return Failure(f"raises {failed.partition(':')[0]}", failed)
    judgement = rehearsal.world.judgement
    assert judgement is not None, "the rehearsal has ended"
    if judgement.breaches:
        return Failure(f"breaks {judgement.breaches[0].broken.invariant}", verdict.reason)
    if case.quiet_s is not None:
        said = unlively(rehearsal.world, rehearsal.entries, quiet_s=case.quiet_s, outside=case.outside)
        return None if said is None else Failure("does not heal or arrive", said)
    return None if verdict.ok else Failure(f"ends: {rehearsal.world.ending}", verdict.reason)


def shrink(case: Case, fails: Callable[[Case], bool]) -> Case:
    """The least case that was found to fail still; `fails` says of one whether it does."""
    while True:
        smaller = _with_fewer_robots(_with_smaller_rules(_with_fewer_rules(case, fails), fails), fails)
        if smaller == case:
            return case
        case = smaller


def _with_rules(case: Case, rules: Sequence[Rule]) -> Case:
    return _changed(case, plan=replace(case.plan, rules=tuple(rules)))


def _changed(case: Case, **changes: Any) -> Case:  # noqa: ANN401 - fields of a case have any type
    said = {name: getattr(case, name) for name in Case.__dataclass_fields__}
    return Case(**(said | changes))


def _with_fewer_rules(case: Case, fails: Callable[[Case], bool]) -> Case:
    """Delta debugging: leave out ever smaller parts of the rules, until none can go."""
    rules = list(case.plan.rules)
    size = max(len(rules) // 2, 1)
    while size > 0:
        before = len(rules)
        for first in range(before - size, -1, -size):
            without = rules[:first] + rules[first + size :]
            if fails(_with_rules(case, without)):
                rules = without
        if len(rules) == before:
            size //= 2
    return _with_rules(case, rules)


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
        smaller = _changed(case, scenario=replace(case.scenario, fleet=fleet))
        if not fails(smaller):
            break
        case = smaller
    return case


def _smaller(rule: Rule, time_s_max: float) -> Iterator[Rule]:
    """What is a little less of a rule, the greatest steps first."""
    yield from _narrower(rule, time_s_max)
    if isinstance(rule, MessageRule):
        yield from _milder(rule)
    for name in ("robots", "occurrence", "copies", "bits"):
        if (count := getattr(rule, name, 1)) > 1:
            yield replace(rule, **{name: count // 2})
    for name in ("delay_s", "delay_s_max", "hold_s", "for_s", "after_s"):
        if (length_s := getattr(rule, name, None)) is not None and length_s > WINDOW_S_MIN:
            yield from _taken(rule, **{name: round(length_s / 2.0, 3)})


def _narrower(rule: Rule, time_s_max: float) -> Iterator[Rule]:
    """A window half as long: the first half, or the second."""
    until_s = time_s_max if rule.until_s is None else rule.until_s
    if until_s - rule.from_s > WINDOW_S_MIN:
        middle_s = round((rule.from_s + until_s) / 2.0, 3)
        yield from _taken(rule, until_s=middle_s)
        yield from _taken(rule, from_s=middle_s)


def _milder(rule: MessageRule) -> Iterator[Rule]:
    if len(rule.kinds) > 1:
        yield from (replace(rule, kinds=(kind,)) for kind in rule.kinds)
    if isinstance(rule.burst, Burst):
        yield replace(rule, burst=replace(rule.burst, loss=rule.burst.loss / 2.0))
    elif rule.probability > 0.02:
        yield replace(rule, probability=round(rule.probability / 2.0, 3))


def _taken(rule: Rule, **changes: object) -> Iterator[Rule]:
    """The changed rule, where a rule may be so."""
    try:
        yield replace(rule, **changes)
    except ValueError:
        return
