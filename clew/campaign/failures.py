"""In which way a run fails: as its folder or its campaign recorded it, and as it fails when rehearsed again.

Rule 1: in the same way means: the same invariant is broken first, or the same exception is raised, or the
        sentence is the same but for its numbers and robots. What else is different does not matter.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from clew.campaign.episode import OUT_OF_TIME, Outcome, OutOfTimeError, Surprise, wall_clock_limit
from clew.campaign.liveness import unlively
from clew.log.check import scenario_of
from clew.log.timeline import Timeline
from clew.rehearsal.recorded import EPOCH, verdict_on
from clew.rehearsal.rehearsal import Rehearsal
from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.timeline import Entry, RobotFailed
from world.judge.judgement import Breach, judge
from world.judge.verdict import Verdict
from world.scenario.scenario import Scenario

WALL_S_MAX = 60.0  # for an episode of a third of a second: then it counts as one that has no end
NO_END = "has no end"
_BROKEN = re.compile(r"([SP]\d) broken by ")
_NUMBERS = re.compile(r"\br?\d+(\.\d+)?(, r?\d+(\.\d+)?)*")


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

    @property
    def told(self) -> str:
        """Both, for people; once where the way is the sentence itself."""
        return self.reason if self.way == _masked(self.reason) else f"{self.way}: {self.reason}"


def failure_of(case: Case) -> Failure | None:
    """Rehearse the case; returns how it fails, or None where it does not."""
    try:
        with wall_clock_limit(WALL_S_MAX):
            rehearsal = Rehearsal(case.scenario, case.seed, case.plan).run()
    except OutOfTimeError:
        return Failure(NO_END, f"it was not over after {WALL_S_MAX:g} s")
    except UsageError:
        return None  # there is no such run
    except Exception as error:
        return Failure(_raising(type(error).__name__), str(error))
    verdict = verdict_on(rehearsal, case.seed, started_at=EPOCH, wall_s=0.0)
    judgement = rehearsal.world.judgement
    assert judgement is not None, "the rehearsal has ended"
    if (found := _worst(rehearsal.entries, judgement.breaches, verdict)) is not None:
        return found
    if case.quiet_s is None:
        return _of_verdict(verdict)
    said = unlively(rehearsal.world, rehearsal.entries, quiet_s=case.quiet_s, outside=case.outside)
    return None if said is None else Failure(_masked(said), said)


def failure_in(timeline: Timeline, verdict: Verdict) -> Failure | None:
    """How a recorded run failed; None where it did not."""
    judgement = judge(scenario_of(timeline), timeline.lines)
    return _worst(timeline.lines, judgement.breaches, verdict) or _of_verdict(verdict)


def failure_told(outcome: Outcome) -> Failure | None:
    """How an episode of a swarm failed, as its campaign has it; None where it did not."""
    reason = outcome.reason
    match outcome.surprise:
        case Surprise.NONE:
            return None
        case Surprise.CRASHED if outcome.ending == OUT_OF_TIME:
            return Failure(NO_END, reason)
        case Surprise.CRASHED:
            return Failure(_raising(reason.removeprefix("a robot failed: ").partition(":")[0]), reason)
        case Surprise.VIOLATION:
            first = _BROKEN.match(reason)
            broken = [name for name, count in outcome.violations_by_invariant.items() if count]
            return Failure(_breaking(broken[0] if first is None else first[1]), reason)
        case _:
            return Failure(_masked(reason), reason)


def _worst(
    entries: Iterable[tuple[str, Entry]], breaches: tuple[Breach, ...], verdict: Verdict
) -> Failure | None:
    """What no run may do, whatever is asked of it: raise, or break an invariant."""
    records = (entry.record for _, entry in entries)
    failed = next((each.reason for each in records if isinstance(each, RobotFailed)), None)
    if failed is not None:
        return Failure(_raising(failed.partition(":")[0]), failed)
    return Failure(_breaking(breaches[0].broken.invariant), verdict.reason) if breaches else None


def _of_verdict(verdict: Verdict) -> Failure | None:
    return None if verdict.ok else Failure(_masked(verdict.reason), verdict.reason)


def _raising(exception: str) -> str:
    return f"raises {exception}"


def _breaking(invariant: str) -> str:
    return f"breaks {invariant}"


def _masked(sentence: str) -> str:
    """Rule 1: a sentence without its numbers."""
    return _NUMBERS.sub("#", sentence)
