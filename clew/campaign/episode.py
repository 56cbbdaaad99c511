"""An episode of a campaign: one scene rehearsed with one seed under a fault plan, and its outcome.

Rule 1: every episode has an outcome, even if it raises or does not end. The campaign continues.
Rule 2: a surprise is an outcome that is not possible if the fleet keeps its promises.
"""

import shlex
import signal
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from types import FrameType

from msgspec import Struct
from msgspec.structs import replace

from clew.campaign.liveness import at_end, liveness_failure
from clew.campaign.scenes import solvable
from clew.campaign.second import second_opinion
from clew.coverage.counters import count_coverage
from clew.rehearsal.endless_law import law_in
from clew.rehearsal.recorded import EPOCH, verdict_on
from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.chain import play_chain
from clew.swarm.futures import draw_future, read_branches, said
from clew.swarm.plans import DRAWN, plan_for
from clew.swarm.swarm import Mode, Swarm, draw
from protocol.faults.plan import NO_FAULTS, Plan
from protocol.timeline import FaultInjected, LawFailed, RobotFailed
from world.judge.ending import Ending
from world.judge.verdict import Verdict
from world.scenario.scenario import Scenario, load

SWARM = "swarm"
"""Used in place of a plan: the seed draws the plan and the world."""
CRASHED, OUT_OF_TIME = "crashed", "out of wall-clock time"


class Surprise(StrEnum):
    """What is wrong with an outcome."""

    NONE = "none"
    VIOLATION = "violation"
    UNREACHED = "unreached"
    """There is a way, but not all robots arrived."""
    FALSE_NO_ROUTE = "false_no_route"
    """There is a way, but the leader reported that there is none."""
    MISSED_NO_ROUTE = "missed_no_route"
    """There is no way, but the leader did not report it."""
    LIVENESS = "liveness"
    """In liveness mode: the faults were over, but the fleet did not heal in time or did not arrive."""
    CRASHED = "crashed"
    JUDGES = "judges"
    """The second judge, of poses alone, contradicts the verdict."""
    STOPPED = "stopped"
    """The wall-clock limit struck: nothing more is known of it, and the machine may be slow."""


class Episode(Struct, frozen=True, kw_only=True):
    """What to rehearse."""

    key: str
    """Two episodes have the same key exactly when they must have the same outcome."""
    path: str
    """The scene's file; for a drawn world, where it is written on request."""
    family: str
    seed: int
    faults: str | None = None
    """A fault plan, `drawn` or `swarm`."""
    robots: int | None
    robots_left_out: int
    law: str | None
    deployment: str | None
    time_s_max: float | None
    widest_path_radius_m: float | None
    wall_s_max: float
    branches: str | None = None
    """Of a swarm: the branches of the future to play; empty: the seed's own faults."""
    guided: bool = False
    """Of a swarm: whether strikes are added to its branches on the way (`clew.swarm.chain`)."""
    judged: bool = False
    """Whether the second judge has to agree with the verdict."""

    @property
    def replay(self) -> str:
        """The command line that replays this episode. A drawn world may not be written yet."""
        if self.faults == SWARM:
            way = f" --future {self.branches}" if self.branches else " --guided" if self.guided else ""
            return f"./launch/clew campaign --faults {SWARM} --seeds {self.seed}{way} --keep"
        given = {
            "-n": self.robots,
            "--law": self.law,
            "--deployment": self.deployment,
            "--time-s-max": None if self.time_s_max is None else f"{self.time_s_max:g}",
            "--faults": self.faults,
            "--seed": self.seed,
        }
        options = [str(word) for pair in given.items() if pair[1] is not None for word in pair]
        return shlex.join(["./launch/clew", "rehearse", self.path, *options])


class Outcome(Struct, frozen=True, kw_only=True):
    """The outcome of an episode: a line of `episodes.jsonl`. docs/campaign.md explains each field."""

    key: str
    scene: str
    family: str
    seed: int
    robots: int | None
    robots_left_out: int
    ok: bool
    ending: str
    reason: str
    surprise: Surprise
    judged: bool = False
    mode: str | None = None
    classes: tuple[str, ...] = ()
    injected: dict[str, int] = {}
    coverage: dict[str, int] = {}
    branches: str = ""
    robots_arrived: int = 0
    goal_reached: bool = False
    no_route: bool = False
    solvable: bool | None = None
    violations: int = 0
    violations_by_invariant: dict[str, int] = {}
    clearance_m_min: float | None = None
    clearance_margin_m: float | None = None
    separation_m_min: float | None = None
    switching_steps: int = 0
    planning_events: int = 0
    path_m: float = 0.0
    events_per_m: float | None = None
    sim_s: float = 0.0
    wall_s: float
    cpu_s: float = 0.0
    replay: str

    @property
    def ended(self) -> bool:
        """Whether the run ended by itself."""
        return self.ending not in (CRASHED, OUT_OF_TIME)


class OutOfTimeError(BaseException):
    """The wall-clock limit was reached. No `Exception`: a rehearsal reports those as failures of a core.

    Its text says in which law of a user, if in one.
    """


@dataclass(frozen=True, slots=True)
class Stage:
    """The input of an episode, loaded or drawn."""

    scenario: Scenario
    plan: Plan
    swarm: Swarm | None = None


def play(episode: Episode) -> Outcome:
    """Rehearse an episode and return its outcome."""
    started_wall_s, started_cpu_s = time.monotonic(), time.process_time()
    stage: Stage | None = None
    rehearsal: Rehearsal | None = None
    try:
        with wall_clock_limit(episode.wall_s_max):
            stage = _set_stage(episode)
            rehearsal = Rehearsal(stage.scenario, episode.seed, stage.plan)
            if not episode.guided:
                rehearsal.run()
            elif stage.swarm is not None:
                for branches, swarm in play_chain(rehearsal, stage.swarm):
                    episode = replace(episode, branches=said(branches))
                    stage = Stage(stage.scenario, swarm.plan, swarm)
    except OutOfTimeError as error:
        at = "while loading" if rehearsal is None else f"at t={rehearsal.world.now_s:.1f} s"
        reason = f"the wall-clock limit of {episode.wall_s_max:g} s struck {at}{error}"
        return failed(episode, OUT_OF_TIME, reason, time.monotonic() - started_wall_s, stage=stage)
    except Exception as error:
        return failed(episode, CRASHED, _last_line(error), time.monotonic() - started_wall_s, stage=stage)
    wall_s, cpu_s = time.monotonic() - started_wall_s, time.process_time() - started_cpu_s
    return replace(_outcome_of(episode, stage, rehearsal, wall_s=wall_s), cpu_s=cpu_s)


def drawn_plan_path(path: str) -> str:
    """The path of the fault plan that belongs to the drawn scene at this path."""
    return str(Path(path).with_suffix(".faults.toml"))


def drawn_replay(path: str, seed: int) -> str:
    """The command line that replays the seed's episode from its written files."""
    return shlex.join(
        ["./launch/clew", "rehearse", path, "--faults", drawn_plan_path(path), "--seed", str(seed)]
    )


def surprise_of(verdict: Verdict, *, expected: int, no_route: bool, solvable: bool | None) -> Surprise:
    """The surprise of a run in which `expected` robots should have arrived."""
    if verdict.violations:
        return Surprise.VIOLATION
    if solvable and no_route:
        return Surprise.FALSE_NO_ROUTE
    if solvable and verdict.robots_arrived < expected:
        return Surprise.UNREACHED
    if solvable is False and not no_route:
        return Surprise.MISSED_NO_ROUTE
    return Surprise.NONE


def _set_stage(episode: Episode) -> Stage:
    """Load or draw the episode's input.

    Raises:
        UsageError: it cannot be loaded.
    """
    if episode.faults == SWARM:
        future = episode.branches
        swarm = draw(episode.seed) if future is None else draw_future(episode.seed, read_branches(future))
        return Stage(swarm.scenario, swarm.plan, swarm)
    scenario = load(
        episode.path,
        robots=episode.robots,
        law=episode.law,
        deployment=episode.deployment,
        time_s_max=episode.time_s_max,
        seed=episode.seed,
    )
    return Stage(scenario, plan_for(episode.faults, robots=scenario.fleet.robots, seed=episode.seed))


def _outcome_of(episode: Episode, stage: Stage, rehearsal: Rehearsal, *, wall_s: float) -> Outcome:
    """The outcome of a rehearsal that has been judged."""
    verdict, world = verdict_on(rehearsal, episode.seed, started_at=EPOCH, wall_s=wall_s), rehearsal.world
    lasting = episode.faults == DRAWN  # faults may last to the end, so nobody has to arrive
    has_way = None if lasting else solvable(episode.widest_path_radius_m, world.scenario)
    no_route = world.ending is Ending.ROUTE_LOST
    least_m = verdict.clearance_m_min
    expected = verdict.robots if stage.plan is NO_FAULTS else len(world.survivors)
    surprise = surprise_of(verdict, expected=expected, no_route=no_route, solvable=has_way)
    outcome = Outcome(
        key=episode.key,
        scene=Path(episode.path).stem,
        family=episode.family,
        seed=episode.seed,
        robots=verdict.robots,
        robots_left_out=episode.robots_left_out,
        ok=verdict.ok,
        ending=str(world.ending),
        reason=verdict.reason,
        surprise=surprise,
        robots_arrived=verdict.robots_arrived,
        goal_reached=verdict.goal_reached,
        no_route=no_route,
        solvable=has_way,
        violations=verdict.violations,
        violations_by_invariant=verdict.violations_by_invariant,
        clearance_m_min=least_m,
        clearance_margin_m=None if least_m is None else least_m - verdict.clearance_m_required,
        separation_m_min=verdict.separation_m_min,
        switching_steps=verdict.switching_steps,
        planning_events=verdict.planning_events,
        path_m=verdict.path_m,
        events_per_m=verdict.planning_events / verdict.path_m if verdict.path_m > 0.0 else None,
        sim_s=verdict.sim_s,
        wall_s=verdict.wall_s,
        replay=episode.replay,
        judged=episode.judged,
        branches=episode.branches or "",
    )
    outcome = _with_law(outcome, rehearsal)
    if stage.plan is not NO_FAULTS:
        outcome = _with_faults(outcome, stage, rehearsal)
    if not episode.judged or outcome.surprise is not Surprise.NONE:
        return outcome
    differs = second_opinion(world.scenario, rehearsal, verdict)
    return outcome if differs is None else replace(outcome, surprise=Surprise.JUDGES, reason=differs)


def _with_law(outcome: Outcome, rehearsal: Rehearsal) -> Outcome:
    """The outcome with how the law has failed, if it has: a lost route may not say so, nor a late arrival."""
    records = (entry.record for _, entry in rehearsal.entries)
    failure = next((each.reason for each in records if isinstance(each, LawFailed)), None)
    if failure is None or outcome.surprise is Surprise.VIOLATION:
        return outcome
    return replace(outcome, surprise=Surprise.CRASHED, reason=failure)


def _with_faults(outcome: Outcome, stage: Stage, rehearsal: Rehearsal) -> Outcome:
    """The outcome with its injections and coverage; in liveness mode also whether the fleet healed."""
    records = [entry.record for _, entry in rehearsal.entries]
    injected = Counter(each.fault for each in records if isinstance(each, FaultInjected))
    outcome = replace(
        outcome,
        injected=dict(sorted(injected.items())),
        coverage=count_coverage(rehearsal.entries, stage.plan),
    )
    if broken := [each for each in records if isinstance(each, RobotFailed)]:
        outcome = replace(outcome, surprise=Surprise.CRASHED, reason=f"a robot failed: {broken[0].reason}")
    swarm, outcome = stage.swarm, _with_classes(outcome, stage.swarm)
    if swarm is None or swarm.mode is Mode.SAFETY or outcome.surprise is not Surprise.NONE:
        return outcome
    reason = liveness_failure(
        at_end(rehearsal.world), rehearsal.entries, quiet_s=swarm.quiet_s, outside=swarm.outside
    )
    return outcome if reason is None else replace(outcome, surprise=Surprise.LIVENESS, reason=reason)


def failed(
    episode: Episode, ending: str, reason: str, wall_s: float, *, stage: Stage | None = None
) -> Outcome:
    """The outcome of an episode that did not end by itself; without a stage, its classes are not known."""
    outcome = Outcome(
        key=episode.key,
        scene=Path(episode.path).stem,
        family=episode.family,
        seed=episode.seed,
        robots=episode.robots,
        robots_left_out=episode.robots_left_out,
        ok=False,
        ending=ending,
        reason=reason,
        surprise=Surprise.STOPPED if ending == OUT_OF_TIME else Surprise.CRASHED,
        judged=episode.judged,
        branches=episode.branches or "",
        wall_s=wall_s,
        replay=episode.replay,
    )
    return outcome if stage is None else _with_classes(outcome, stage.swarm)


def _with_classes(outcome: Outcome, swarm: Swarm | None) -> Outcome:
    """The outcome with what its seed has drawn, if that has drawn anything."""
    if swarm is None:
        return outcome
    return replace(outcome, mode=swarm.mode, classes=tuple(map(str, swarm.classes)))


def _last_line(error: Exception) -> str:
    """The message of an exception, and where it was raised."""
    said = traceback.format_exception_only(error)[-1].strip().splitlines()[-1]
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return f"{said} ({Path(frame.filename).name}:{frame.lineno})"


@contextmanager
def wall_clock_limit(limit_s: float) -> Iterator[None]:
    """Raise `OutOfTimeError` in the body when the time is up, even in an endless loop."""

    def strike(_number: int, frame: FrameType | None) -> None:
        law = law_in(frame)
        raise OutOfTimeError("" if law is None else f", in the law {law}, which may never return")

    before = signal.signal(signal.SIGALRM, strike)
    signal.setitimer(signal.ITIMER_REAL, limit_s)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
