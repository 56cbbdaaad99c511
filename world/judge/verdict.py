"""The verdict: whether a run kept its promises and, if not, the first broken one in a sentence."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from msgspec import Struct
from msgspec.structs import replace as with_fields

from protocol.errors import sentence_of
from protocol.exit_codes import ExitCode
from protocol.timeline import FaultInjected, PromiseBroken, RouteLost
from protocol.timeline.invariants import compared, named
from world.judge.books import Messages
from world.judge.ending import Ending
from world.judge.judgement import Judgement
from world.judge.monitor import Promises
from world.judge.recovery import Death, Heal, Recovery, Succession
from world.judge.table import table_rms_m
from world.judge.tally import Tally
from world.scenario.scenario import Scenario

VERDICT_FILE = "verdict.json"
KEPT_UP = 0.9  # of the speed: starting and a few long computations cost a short run some percent
NO_ROUTE = "no_route: "
"""The beginning of the reason if the run ended because the leader found no way."""


class Late(Struct, frozen=True, kw_only=True):
    """How late the ticks of a live run were, against the speed that was asked for [wall s]."""

    p50_s: float
    p99_s: float


class Events(Struct, frozen=True, kw_only=True):
    """The completeness of the timeline."""

    recorded: int
    """Entries that were read back from the file."""
    missing: int
    """Entries that were to be written and were not."""
    lost: int = 0
    """Entries that were written and do not stand in the file."""


@dataclass(frozen=True, slots=True)
class Flaw:
    """A flaw of a run in a sentence; the first flaw decides the exit code."""

    sentence: str
    exit_code: ExitCode = ExitCode.FAILED


ENDED_BY_SIGNAL = {
    Ending.INTERRUPTED: Flaw("the run was interrupted", ExitCode.INTERRUPTED),
    Ending.TERMINATED: Flaw("the run was told to end", ExitCode.TERMINATED),
    Ending.HUNG_UP: Flaw("the terminal of the run was closed", ExitCode.HUNG_UP),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Facts:
    """The input of a verdict."""

    scenario: Scenario
    seed: int
    speed: float | None
    started_at: str
    ending: Ending
    absent: str
    """The robots that never came."""
    living: frozenset[int]
    """The robots that were alive when the run was over."""
    tally: Tally
    judgement: Judgement
    messages: Messages
    events: Events
    unstruck: tuple[str, ...]
    """Rules of the fault plan that never struck."""
    sim_s: float
    wall_s: float
    cpu_s: float
    speed_reached: float | None = None
    ticks_late: Late | None = None

    @property
    def goal_reached(self) -> bool:
        """Whether a leader recorded it, and no such entry was untrue."""
        return self.tally.goal_reached and self.judgement.violations["A1"] == 0

    @property
    def arrived(self) -> set[int]:
        """The living robots that recorded their arrival, and never an untrue one.

        Without a goal, only a place in the newest strand counts: an older strand may have ended elsewhere.
        """
        there = self.living if self.scenario.goal is not None else self.living.intersection(self.tally.order)
        return (self.tally.arrived & there) - self.judgement.untrue


class Verdict(Struct, frozen=True, kw_only=True):
    """`verdict.json`; docs/verdict.md explains the fields."""

    ok: bool
    exit_code: int
    reason: str
    scenario: str
    seed: int
    robots: int
    law: str
    speed: float | None
    """Requested simulated seconds per second; null: as fast as the robots answer."""
    started_at: str
    no_route: bool
    """The run ended because the leader found no way."""
    goal_reached: bool
    robots_arrived: int
    clearance_m_min: float | None
    """Null: there is no obstacle."""
    clearance_m_required: float
    moving_clearance_m_min: float | None
    """Null: no obstacle moves."""
    separation_m_min: float | None
    """Null: there is only one robot."""
    separation_m_required: float
    violations: int
    violations_by_invariant: dict[str, int]
    switching_steps: int
    planning_events: int
    scans: int
    path_m: float
    table_rms_m: float | None
    sim_s: float
    wall_s: float
    cpu_s: float
    """Of the world's own process."""
    speed_reached: float | None = None
    """Simulated seconds per wall-clock second while the clock ran; null: in lock-step or rehearsed."""
    slowness: str | None = None
    """A sentence where that is much less than `speed`; null: the machine was fast enough."""
    ticks_late: Late | None = None
    """Null: in lock-step or rehearsed."""
    messages: Messages
    events: Events
    deaths: tuple[Death, ...]
    successions: tuple[Succession, ...] = ()
    heals: tuple[Heal, ...] = ()
    unstruck: tuple[str, ...] = ()
    """Rules of the fault plan that never struck."""


def pass_verdict(facts: Facts) -> Verdict:
    """The verdict on a judged run; a failed one where it cannot be judged, which should never happen."""
    scenario, tally = facts.scenario, facts.tally
    try:
        rms_m = table_rms_m(scenario, tally.switching_positions)
        return _verdict(facts, Recovery(tally.recovery), rms_m)
    except Exception as error:
        failed = with_fields(facts.judgement, failure=sentence_of(error))
        return _verdict(replace(facts, judgement=failed), Recovery(()), None)


def _verdict(facts: Facts, recovery: Recovery, rms_m: float | None) -> Verdict:
    scenario, tally, judgement = facts.scenario, facts.tally, facts.judgement
    promises = Promises.of(scenario)
    flaws = list(_flaws(facts, recovery))
    return Verdict(
        ok=not flaws,
        exit_code=flaws[0].exit_code if flaws else ExitCode.OK,
        reason=flaws[0].sentence if flaws else str(facts.ending),
        scenario=scenario.name,
        seed=facts.seed,
        robots=scenario.fleet.robots,
        law=scenario.law.law,
        speed=facts.speed,
        started_at=facts.started_at,
        no_route=facts.ending is Ending.ROUTE_LOST,
        goal_reached=facts.goal_reached,
        robots_arrived=len(facts.arrived),
        clearance_m_min=finite(judgement.least_clearance.distance_m),
        clearance_m_required=promises.clearance_m_required,
        moving_clearance_m_min=finite(judgement.least_moving_clearance.distance_m),
        separation_m_min=finite(judgement.least_separation.distance_m),
        separation_m_required=promises.separation_m_required,
        violations=sum(judgement.violations.values()),
        violations_by_invariant=judgement.violations,
        switching_steps=tally.switching_steps,
        planning_events=tally.planning_events,
        scans=tally.scans,
        path_m=judgement.path_m,
        table_rms_m=rms_m,
        sim_s=facts.sim_s,
        wall_s=facts.wall_s,
        cpu_s=facts.cpu_s,
        speed_reached=None if facts.speed_reached is None else round(facts.speed_reached, 3),
        slowness=slowness(scenario.fleet.robots, facts.speed, facts.speed_reached),
        ticks_late=facts.ticks_late,
        messages=facts.messages,
        events=facts.events,
        deaths=recovery.deaths,
        successions=recovery.successions,
        heals=recovery.heals,
        unstruck=facts.unstruck,
    )


def slowness(robots: int, speed: float | None, reached: float | None) -> str | None:
    """What to say of a machine on which a run was much slower than asked; None: nothing."""
    if speed is None or reached is None or reached >= KEPT_UP * speed:
        return None
    return f"the machine is too slow for {robots} robots at speed {speed:g}: ran at {reached:.2g}"


def _flaws(facts: Facts, recovery: Recovery) -> Iterator[Flaw]:
    """The flaws of the run, the first broken promise first."""
    if facts.judgement.failure is not None:
        yield Flaw(f"the judge failed: {facts.judgement.failure}")
    tally, arrived, living = facts.tally, len(facts.arrived), len(facts.living)
    dated = [(breach.t_s, _breach_sentence(breach.t_s, breach.broken)) for breach in facts.judgement.breaches]
    dated += [(death.cause_s, _death_sentence(death)) for death in recovery.unrequested]
    if tally.route_lost is not None and facts.ending not in ENDED_BY_SIGNAL:
        dated.append((tally.route_lost[0], f"{NO_ROUTE}{_route_sentence(*tally.route_lost)}"))
    yield from (Flaw(sentence) for _, sentence in sorted(dated))
    yield from _flaws_of_ending(facts)
    if not facts.goal_reached:
        yield Flaw("the goal was not reached")
    if arrived < living:
        yield Flaw(f"{arrived} of {living} living robots arrived")
    if facts.events.missing > 0:
        yield Flaw(f"{facts.events.missing} entries of the timeline never came")
    if disagreements := facts.messages.disagreements:
        more = f" (and {len(disagreements) - 1} more)" if len(disagreements) > 1 else ""
        yield Flaw(f"the books disagree: {disagreements[0]}{more}")
    if facts.events.lost > 0:
        yield Flaw(f"{facts.events.lost} entries that were written do not stand in the timeline")


def _flaws_of_ending(facts: Facts) -> Iterator[Flaw]:
    """The flaws in the end of the run itself; a lost route is among the dated ones."""
    down, stranded = facts.tally.world_down, _stranded_sentence(facts)
    tried = facts.tally.attempt.sentence + (f"; no way for {stranded}" if stranded else "")
    if down is not None and facts.ending not in (Ending.ARRIVED, *ENDED_BY_SIGNAL):
        yield Flaw(_down_sentence(down))
    match facts.ending:
        case Ending.INTERRUPTED | Ending.TERMINATED | Ending.HUNG_UP:
            flaw, lost = ENDED_BY_SIGNAL[facts.ending], facts.tally.route_lost
            # The request comes first: it may be what stopped a law that never returns.
            yield (
                flaw if lost is None else replace(flaw, sentence=f"{flaw.sentence}; {_route_sentence(*lost)}")
            )
        case Ending.CUT_OFF:
            yield Flaw(f"the router was lost by t={facts.sim_s:.1f} s")
        case Ending.MISSING:
            yield Flaw(f"robots never came: {facts.absent}")
        case Ending.TIMED_OUT:
            arrived, living = len(facts.arrived), len(facts.living)
            yield Flaw(f"the time was up with {arrived} of {living} living robots arrived: {tried}")
        case Ending.STRANDED:
            yield Flaw(f"no way for {stranded}")
        case Ending.STUCK:
            yield Flaw(f"by t={facts.sim_s:.1f} s nothing had moved for long: {tried}")
        case Ending.EXTINCT | Ending.LOST_PROCESS:
            yield Flaw(str(facts.ending))
        case Ending.ARRIVED | Ending.ROUTE_LOST:
            pass


def _breach_sentence(t_s: float, broken: PromiseBroken) -> str:
    against = "" if broken.other is None else f" and robot {broken.other}"
    what = f"{named(broken.invariant)} broken by robot {broken.robot}{against} at t={t_s:.1f} s"
    lengths = compared(broken.measured_m, broken.required_m, ", required ")
    return f"{what}: {broken.why}{f' ({lengths})' if lengths else ''}"


def _down_sentence(down: FaultInjected) -> str:
    """What became of a world that a rehearsal went on without: a live one is always started again."""
    if down.fault == "kill":
        return f"the world was killed by {down.rule} and never started again"
    return f"the world was frozen by {down.rule} and never thawed"


def _stranded_sentence(facts: Facts) -> str:
    """Which living robots are stranded, and why."""
    tally = facts.tally
    return "; ".join(
        f"robot {robot}: {each.reason}"
        + ("" if each.by is None else f" (behind the body of robot {each.by})")
        for robot, each in sorted(tally.stranded.items())
        if robot in facts.living - tally.arrived
    )


def _route_sentence(t_s: float, lost: RouteLost) -> str:
    return f"the leader lost its route at t={t_s:.1f} s: {lost.reason}"


def _death_sentence(death: Death) -> str:
    when = f"at t={death.cause_s:.1f} s (known at t={death.known_s:.1f} s)"
    return f"robot {death.robot} died {when}, and nobody had asked for it"


def finite(distance_m: float) -> float | None:
    """The distance; None if there was nothing to measure."""
    return distance_m if distance_m < float("inf") else None
