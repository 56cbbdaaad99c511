"""Live chaos: judges real fleets under the faults that a swarm has drawn. It only reads.

Rule 1: a trouble is what no fault excuses: a violation, live or in the log; message counts that do not
        balance; an incomplete log; a launcher that refuses or does not end; an end without a verdict;
        processes, sockets or files left behind.
Rule 2: not arriving is no trouble, since faults may leave no way. It is reported with its replay line.
Rule 3: where the seed's faults end, the fleet must heal and arrive as in a rehearsal
        (`clew.campaign.liveness`). What it failed to do is reported, but is no trouble either: a busy machine
        may have been the cause.
"""

import math
import shlex
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from msgspec import Struct

from clew.campaign.episode import drawn_plan_path
from clew.campaign.liveness import AtEnd, arrived_together, just_killed, liveness_failure, places_at
from clew.fleet.live import Ended
from clew.fleet.runs import verdict_in
from clew.log.check import Finding, check
from clew.log.completeness import LAST_MISSING
from clew.log.timeline import Timeline, read
from clew.swarm.swarm import Mode, Swarm
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.timeline import FaultInjected, RobotDied, RobotRestarted, RobotReturned, RunEnded
from protocol.timeline.invariants import counted
from world.judge.books import Messages
from world.judge.ending import ASKED, Ending
from world.judge.truth.voices import concerned
from world.judge.verdict import Verdict
from world.record.lines import Line
from world.scenario.scenario import Scenario


class ChaosRun(Struct, frozen=True, kw_only=True):
    """The result of one live fleet."""

    seed: int
    mode: str
    ground: str
    classes: tuple[str, ...]
    """Classes of faults (clew/swarm/classes.py)."""
    robots: int
    code: int | None
    """The exit code of the launcher; null: it had to be killed."""
    ending: str | None
    reason: str
    arrived: bool
    """Whether all robots arrived that were alive at the end and have no permanent fault."""
    robots_arrived: int
    had_to_recover: bool
    """Whether rule 3 applies: its faults end, and so did the run, not by a request from outside."""
    not_recovered: str | None
    """What the fleet failed to do after its faults, though it had a way (rule 3); null: nothing."""
    process_faults: dict[str, int]
    """Process faults by kind."""
    violations: int
    violations_by_invariant: dict[str, int]
    messages: Messages | None
    events_missing: int
    log_ok: bool
    """The result of `clew log check`."""
    log_flaws: tuple[str, ...]
    leftovers: tuple[str, ...]
    sim_s: float
    wall_s: float
    load: float
    """Load average of the last minute, at the end of the run."""
    troubles: tuple[str, ...]
    """Rule 1."""
    replay: str


class Chaos(Struct, frozen=True, kw_only=True):
    """`chaos.json`."""

    ok: bool
    interrupted: bool
    runs_asked: int
    runs: int
    speed: str
    violations: int
    unbalanced: int
    leftovers: int
    not_arrived: int
    liveness_runs: int
    """The runs that had to recover (rule 3)."""
    not_recovered: int
    messages_sent: int
    messages_unaccounted: int
    process_faults: dict[str, int]
    each: tuple[ChaosRun, ...]


def replay_line(path: Path, seed: int, speed: str) -> str:
    """The command line for the same world, plan and seed; the timing of the processes differs."""
    plan = drawn_plan_path(str(path))
    options = ["--faults", plan, "--seed", str(seed), "--speed", speed]
    return shlex.join(["./launch/fleet.sh", str(path), *options])


def judge_run(swarm: Swarm, folder: Path, ended: Ended, *, replay: str, load: float) -> ChaosRun:
    """The result of the fleet whose run is in this folder."""
    verdict, timeline, finding = _read(folder)
    entries, fleet = [], None
    if timeline is not None and finding is not None:
        entries = sorted(concerned(timeline.lines), key=lambda line: line[1].t_s)
        fleet = fleet_in(timeline, swarm.scenario, untrue=finding.untrue)
    said = ended.said[-1] if ended.said else "the launcher printed nothing"
    return ChaosRun(
        seed=swarm.seed,
        mode=swarm.mode,
        ground=swarm.ground,
        classes=tuple(map(str, swarm.classes)),
        robots=swarm.scenario.fleet.robots,
        code=ended.code,
        ending=None if timeline is None else timeline.ended,
        reason=said if verdict is None else verdict.reason,
        arrived=fleet is not None and has_arrived(fleet, entries, outside=swarm.outside),
        robots_arrived=0 if verdict is None else verdict.robots_arrived,
        had_to_recover=fleet is not None and swarm.mode is Mode.LIVENESS,
        not_recovered=None if fleet is None else not_recovered(fleet, entries, swarm),
        process_faults={} if timeline is None else process_faults_in(timeline),
        violations=0 if verdict is None else verdict.violations,
        violations_by_invariant={} if verdict is None else verdict.violations_by_invariant,
        messages=None if verdict is None else verdict.messages,
        events_missing=0 if verdict is None else verdict.events.missing,
        log_ok=finding is not None and finding.ok,
        log_flaws=() if finding is None else finding.flaws,
        leftovers=ended.leftovers,
        sim_s=0.0 if verdict is None else verdict.sim_s,
        wall_s=ended.wall_s,
        load=load,
        troubles=tuple(troubles_of(verdict, finding, ended)),
        replay=replay,
    )


def troubles_of(verdict: Verdict | None, finding: Finding | None, ended: Ended) -> Iterator[str]:
    """One sentence for each trouble (rule 1)."""
    if ended.code is None:
        yield "the launcher did not end when it was asked to"
    elif ended.code == ExitCode.USAGE:
        yield ": ".join(("the launcher refused", *ended.said[-1:]))
    if verdict is None:
        yield "there is no verdict"
    elif verdict.violations:
        yield f"broken: {counted(verdict.violations_by_invariant)}"
    if verdict is not None and not is_balanced(verdict.messages):
        yield "the message counts do not balance"
    # A robot that is cut off to the end cannot send its last entries; one that has arrived can.
    if verdict is not None and verdict.events.missing and finding and finding.ended == Ending.ARRIVED:
        yield f"{verdict.events.missing} entries of the timeline are missing"
    if finding is None:
        yield "the log cannot be read"
    else:
        excused = () if finding.ended == Ending.ARRIVED else (LAST_MISSING,)  # likewise
        flaws = "; ".join(each for each in finding.flaws if not each.endswith(excused))
        if finding.violations or flaws:
            yield f"log check: {finding.violations} violations{flaws and f'; {flaws}'}"
    if ended.leftovers:
        yield f"left behind: {', '.join(ended.leftovers)}"


def is_balanced(messages: Messages) -> bool:
    """Whether the counts add up to the messages sent, and none was received that was not sent."""
    accounted = messages.received + sum(messages.injected.values()) + messages.refused
    return messages.unaccounted >= 0 and messages.sent == accounted + messages.unaccounted


def fleet_in(timeline: Timeline, scenario: Scenario, *, untrue: frozenset[int]) -> AtEnd | None:
    """The fleet at the end of a log; None where the run did not begin, or not end by itself."""
    living = set(range(1, scenario.fleet.robots + 1))
    over_s = math.nan
    for _, entry in timeline.lines:
        match entry.record:
            case RobotDied(robot=robot):
                living.discard(robot)
            case RobotReturned(robot=robot) | RobotRestarted(robot=robot):
                living.add(robot)
            case RunEnded():
                over_s = entry.t_s
            case _:
                pass
    places_m = places_at(timeline.lines, math.inf, np.full((scenario.fleet.robots, 2), math.nan))
    if np.isnan(places_m).any() or timeline.ended in (None, *ASKED.values()):
        return None
    return AtEnd(
        scenario=scenario,
        places_m=places_m,
        living=frozenset(living),
        untrue=untrue,
        ending=timeline.ended,
        over_s=over_s,
    )


def has_arrived(fleet: AtEnd, entries: Iterable[Line], *, outside: frozenset[int]) -> bool:
    """Whether the robots that should arrive were all at the goal at the same time, by true poses."""
    if fleet.ending == Ending.ARRIVED:
        return not fleet.untrue
    core = sorted(fleet.living - outside - just_killed(entries))
    return core != [] and arrived_together(entries, core, untrue=fleet.untrue)


def not_recovered(fleet: AtEnd, entries: Iterable[Line], swarm: Swarm) -> str | None:
    """What the fleet failed to do after its faults (rule 3); None also where they do not end."""
    if swarm.mode is Mode.SAFETY:
        return None
    return liveness_failure(fleet, entries, quiet_s=swarm.quiet_s, outside=swarm.outside)


def process_faults_in(timeline: Timeline) -> dict[str, int]:
    """How often each kind of process fault was injected in a run."""
    records = (entry.record for _, entry in timeline.lines)
    return _sorted(
        Counter(each.fault for each in records if isinstance(each, FaultInjected) and each.process)
    )


def sum_up(runs: Sequence[ChaosRun], *, asked: int, speed: str, interrupted: bool) -> Chaos:
    """The summary of all runs."""
    process_faults: Counter[str] = Counter()
    for run in runs:
        process_faults.update(run.process_faults)
    books = [run.messages for run in runs if run.messages is not None]
    return Chaos(
        ok=not interrupted and not any(run.troubles for run in runs),
        interrupted=interrupted,
        runs_asked=asked,
        runs=len(runs),
        speed=speed,
        violations=sum(run.violations for run in runs),
        unbalanced=len(runs) - sum(map(is_balanced, books)),
        leftovers=sum(len(run.leftovers) for run in runs),
        not_arrived=sum(not run.arrived for run in runs),
        liveness_runs=sum(run.had_to_recover for run in runs),
        not_recovered=sum(run.not_recovered is not None for run in runs),
        messages_sent=sum(each.sent for each in books),
        messages_unaccounted=sum(each.unaccounted for each in books),
        process_faults=_sorted(process_faults),
        each=tuple(runs),
    )


def _read(folder: Path) -> tuple[Verdict | None, Timeline | None, Finding | None]:
    """The readable parts of a run's folder."""
    verdict = verdict_in(folder, Verdict)
    try:
        timeline = read(folder)
        return verdict, timeline, check(timeline)
    except UsageError:
        return verdict, None, None


def _sorted(counts: Counter[str]) -> dict[str, int]:
    return dict(sorted(counts.items()))
