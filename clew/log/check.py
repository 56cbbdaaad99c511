"""Judges a run again from its log alone, by the rules that judged it live, and finds gaps in the log."""

from collections.abc import Iterable, Iterator

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from clew.log.log import Log
from clew.log.summary import verdict_beside
from clew.log.timeline import Timeline
from protocol.errors import UsageError
from protocol.plain import plain
from protocol.run_settings import SCENARIO_FILE
from protocol.timeline import PromiseBroken
from protocol.timeline.invariants import compared, counted, named
from world.judge.judgement import Breach, Judgement, judge, untrue_in
from world.judge.monitor import Promises
from world.judge.verdict import VERDICT_FILE, finite
from world.record.lines import Line
from world.record.run_files import check_unchanged
from world.scenario.scenario import Scenario

JUDGED = (
    "clearance_m_min",
    "clearance_m_required",
    "moving_clearance_m_min",
    "separation_m_min",
    "separation_m_required",
    "path_m",
)
"""What a verdict and a finding say of the same log."""
ROUNDING_M = 1e-6


class Finding(Struct, frozen=True, kw_only=True):
    """What a log shows. It is good when no promise was broken and nothing is missing."""

    ok: bool
    violations: int
    violations_by_invariant: dict[str, int]
    clearance_m_min: float | None
    """None: there was no obstacle."""
    clearance_m_required: float
    moving_clearance_m_min: float | None
    """None: there was no moving obstacle."""
    separation_m_min: float | None
    """None: there was one robot only."""
    separation_m_required: float
    path_m: float
    ended: str | None
    """How the run ended; None: the log does not say."""
    breaches: tuple[Breach, ...]
    flaws: tuple[str, ...]
    """What is missing from the log, cannot be read, or contradicts the rest."""

    @property
    def untrue(self) -> frozenset[int]:
        """The robots that recorded an arrival which their poses do not show."""
        return untrue_in(self.breaches)


def check(timeline: Timeline | Log) -> Finding:
    """Judge S1 to S4, F1 to F6, P1 to P7, A1 and A2, and whether the log is complete.

    Raises:
        UsageError: the header has no scenario that this version can read.
    """
    scenario = scenario_of(timeline)
    judgement, recorded = _judged(timeline, scenario)
    if timeline.ended is None and any(contradictions(recorded, judgement)):
        # What waits for entries is decided when the run is over: the world has decided, and died then.
        judgement, recorded = _judged(timeline, scenario, is_over=True)
    promises = Promises.of(scenario)
    flaws = [*timeline.flaws, *contradictions(recorded, judgement), *_changed(timeline)]
    if judgement.failure is not None:
        flaws.append(f"the judge failed: {judgement.failure}")
    if scenario.fingerprint() != timeline.header.scenario_hash:
        flaws.append("the scenario in the header is not the one that was run: its hash differs")
    finding = Finding(
        ok=not judgement.breaches and not flaws,
        violations=sum(judgement.violations.values()),
        violations_by_invariant=judgement.violations,
        clearance_m_min=finite(judgement.least_clearance.distance_m),
        clearance_m_required=promises.clearance_m_required,
        moving_clearance_m_min=finite(judgement.least_moving_clearance.distance_m),
        separation_m_min=finite(judgement.least_separation.distance_m),
        separation_m_required=promises.separation_m_required,
        path_m=judgement.path_m,
        ended=timeline.ended,
        breaches=judgement.breaches,
        flaws=tuple(flaws),
    )
    denied = tuple(_denied(timeline, finding))
    return replace(finding, ok=finding.ok and not denied, flaws=(*finding.flaws, *denied))


def _judged(
    timeline: Timeline | Log, scenario: Scenario, *, is_over: bool = False
) -> tuple[Judgement, list[Breach]]:
    """What a timeline shows, and the broken promises that are recorded in it.

    `is_over`: its run was over, though the log does not say so.
    """
    recorded: list[Breach] = []
    lines = _noting(recorded, timeline.lines)
    return judge(scenario, lines, cut_off=lambda: timeline.ended is None and not is_over), recorded


def _noting(broken: list[Breach], lines: Iterable[Line]) -> Iterator[Line]:
    """The same lines; adds the broken promises in them to a list, so that a long log is read only once."""
    for source, entry in lines:
        if isinstance(entry.record, PromiseBroken):
            broken.append(Breach(t_s=entry.t_s, broken=entry.record))
        yield source, entry


def _denied(timeline: Timeline | Log, finding: Finding) -> Iterator[str]:
    """In what the verdict beside a log says something else than the log: both are judged from that alone."""
    if not isinstance(timeline, Log):
        return
    verdict, flaws = verdict_beside(timeline.path)
    yield from flaws
    if verdict is None:
        return
    if not verdict.ok and verdict.sim_s == 0.0 and not any(verdict.violations_by_invariant.values()):
        return  # the launcher's, of a run that nobody could judge
    for name in JUDGED:
        said, found = getattr(verdict, name), getattr(finding, name)
        if (said is None) != (found is None) or (said is not None and abs(said - found) > ROUNDING_M):
            yield f"{VERDICT_FILE}: {name} is {said}, by the log {found}"
    said, found = (counted(each.violations_by_invariant) or "none" for each in (verdict, finding))
    if said != found:
        yield f"{VERDICT_FILE}: violations: {said}, by the log {found}"
    if verdict.ok and verdict.violations:
        yield f"{VERDICT_FILE}: is ok and has {verdict.violations} violations"


def _changed(timeline: Timeline | Log) -> Iterator[str]:
    """Say so if the scenario or the fault plan in the run's folder has changed since the run began."""
    if not isinstance(timeline, Log) or not (timeline.path.parent / SCENARIO_FILE).exists():
        return
    try:
        check_unchanged(timeline.path.parent, timeline.header)
    except UsageError as error:
        yield str(error)


def contradictions(recorded: Iterable[Breach], judgement: Judgement) -> Iterator[str]:
    """Broken promises in the log that the second judgement does not find."""
    found = {_who(breach.broken) for breach in judgement.breaches}
    for breach in recorded:
        if _who(breach.broken) not in found:
            who = f"{named(breach.broken.invariant)}, robot {breach.broken.robot}"
            yield f"{who}: recorded as broken at t={breach.t_s} s, but not found again"


def _who(broken: PromiseBroken) -> tuple[str, int, int | None]:
    return broken.invariant, broken.robot, broken.other


def scenario_of(timeline: Timeline | Log) -> Scenario:
    """The scenario in the header.

    Raises:
        UsageError: it is missing, or of another version.
    """
    try:
        return msgspec.convert(timeline.header.scenario, Scenario)
    except (msgspec.ValidationError, UsageError) as error:
        place = f"{timeline.path}: line 1" if isinstance(timeline, Log) else "line 1"
        if not timeline.header.scenario:
            raise UsageError(f"{place}, the header, is damaged: it has no scenario to judge by") from error
        raise UsageError(f"{place}: the scenario in the header cannot be read: {error}") from error


def sentences(finding: Finding) -> list[str]:
    """A finding for people: a line for each flaw, how the run ended, and the result in the last line."""
    return list(map(plain, _sentences(finding)))


def _sentences(finding: Finding) -> list[str]:
    broken = [
        f"t={breach.t_s:.3f} s: {named(breach.broken.invariant)}, robot {breach.broken.robot}: "
        f"{breach.broken.why}{_lengths(breach.broken)}"
        for breach in finding.breaches
    ]
    flaws = [f"not complete: {flaw}" for flaw in finding.flaws]
    ended = [] if finding.ended is None else [f"ended: {finding.ended}"]
    violations = f"violations: {counted(finding.violations_by_invariant) or 'none'}"
    least = (
        f"clearance {_metres(finding.clearance_m_min)} ({finding.clearance_m_required:.4f} m required), "
        f"separation {_metres(finding.separation_m_min)} ({finding.separation_m_required:.4f} m required)"
    )
    word = "kept" if finding.ok else "not proved" if not finding.breaches else "broken"
    return [
        *broken,
        *flaws,
        *ended,
        f"{word}: {violations}; {least}; {finding.path_m:.3f} m driven",
    ]


def _lengths(broken: PromiseBroken) -> str:
    lengths = compared(broken.measured_m, broken.required_m, " against ")
    return f": {lengths}" if lengths else ""


def _metres(distance_m: float | None) -> str:
    return "none" if distance_m is None else f"{distance_m:.4f} m"
