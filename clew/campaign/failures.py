"""How a run fails: as its folder or its campaign recorded it, and when it is rehearsed again.

Rule 1: two runs fail in the same way if the same invariant is broken first, or the same exception is raised,
        or the sentences differ only in numbers and robots. Other differences do not matter, nor does what a
        fleet was doing when its run ended.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from clew.campaign.episode import Outcome, OutOfTimeError, Surprise, wall_clock_limit
from clew.campaign.liveness import at_end, liveness_failure
from clew.log.check import scenario_of
from clew.log.timeline import Timeline
from clew.rehearsal.recorded import EPOCH, verdict_on
from clew.rehearsal.rehearsal import Rehearsal
from protocol.errors import UsageError
from protocol.faults.plan import Plan
from protocol.timeline import Entry, RobotFailed
from protocol.timeline.invariants import named
from world.judge.judgement import Breach, judge
from world.judge.verdict import Verdict
from world.scenario.scenario import Scenario

WALL_S_MAX = 300.0  # as in a campaign: a case of 9 s of CPU may take more than 60 s on a busy machine
NO_END = "has no end"
_BROKEN = re.compile(r"([SFPA]\d) .*?broken by ")
_DOING = re.compile(r"(the time was up [^:]*|nothing had moved for long): .*")
_NUMBERS = re.compile(r"\br?\d+(\.\d+)?(, r?\d+(\.\d+)?)*")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A run that fails, or part of one."""

    scenario: Scenario
    seed: int
    plan: Plan
    quiet_s: float | None = None
    """From this time on the fleet must heal; None: healing is not checked."""
    outside: frozenset[int] = frozenset()


@dataclass(frozen=True, slots=True)
class Failure:
    """How a run failed (rule 1), and the reason that it gave."""

    way: str
    reason: str

    @property
    def sentence(self) -> str:
        """Way and reason for people, without repeating a way that is the masked reason."""
        return self.reason if self.way == _masked(self.reason) else f"{self.way}: {self.reason}"


def failure_of(case: Case) -> Failure | None:
    """Rehearse the case; returns how it fails, or None."""
    try:
        with wall_clock_limit(WALL_S_MAX):
            rehearsal = Rehearsal(case.scenario, case.seed, case.plan).run()
    except OutOfTimeError as error:
        return Failure(NO_END, f"the run had not ended after {WALL_S_MAX:g} s{error}")
    except UsageError:
        return None  # such a run is refused
    except Exception as error:
        return Failure(_raising(type(error).__name__), str(error))
    verdict = verdict_on(rehearsal, case.seed, started_at=EPOCH, wall_s=0.0)
    judgement = rehearsal.world.judgement
    assert judgement is not None, "the rehearsal has ended"
    if (found := _worst(rehearsal.entries, judgement.breaches, verdict)) is not None:
        return found
    if case.quiet_s is None:
        return _of_verdict(verdict)
    said = liveness_failure(
        at_end(rehearsal.world), rehearsal.entries, quiet_s=case.quiet_s, outside=case.outside
    )
    return None if said is None else Failure(_masked(said), said)


def failure_in(timeline: Timeline, verdict: Verdict) -> Failure | None:
    """How a recorded run failed, or None."""
    judgement = judge(scenario_of(timeline), timeline.lines)
    return _worst(timeline.lines, judgement.breaches, verdict) or _of_verdict(verdict)


def failure_of_outcome(outcome: Outcome) -> Failure | None:
    """How a swarm episode failed according to its campaign, or None."""
    reason = outcome.reason
    match outcome.surprise:
        case Surprise.NONE:
            return None
        case Surprise.STOPPED:
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
    """The failure that no run may have in any mode: an exception, or a broken invariant."""
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
    return f"breaks {named(invariant)}"


def _masked(sentence: str) -> str:
    """A sentence without what does not matter (rule 1)."""
    return _NUMBERS.sub("#", _DOING.sub(r"\1", sentence))
