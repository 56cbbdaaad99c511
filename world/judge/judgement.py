"""The judge of a run: entries in, violations out. The same object judges live runs, rehearsals and logs.

Rule 1: an entry is judged when it comes, and costs the same late in a run as early. `close` costs the same
        after an hour as after a minute: at most the last few seconds are judged there, and what robots that
        died were still to say.
Rule 2: what is kept does not grow with the entries, but for a few numbers for each step, fence and formation.
Rule 3: the timeline is the only input.
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence

from msgspec import Struct

from protocol.errors import sentence_of
from protocol.keys import WORLD
from protocol.timeline import Entry, FenceChanged, PromiseBroken
from protocol.timeline.invariants import INVARIANTS
from world.judge.monitor import Least
from world.judge.rules.authority import Authority
from world.judge.rules.claims import Claims
from world.judge.rules.distances import Distances
from world.judge.rules.evidence import Evidence
from world.judge.rules.fences import FenceOrder
from world.judge.rules.formations import Formations
from world.judge.rules.invariants import ARRIVAL, Counting, Epochs, Granting, Leading, Numbers
from world.judge.rules.motion import Motion, Tolerance
from world.judge.rules.rule import Dated, Rule, Waiting
from world.judge.rules.watched import Watched
from world.judge.truth.truth import Truth
from world.scenario.scenario import Scenario


class Breach(Struct, frozen=True, kw_only=True):
    """A broken promise and its time."""

    t_s: float
    broken: PromiseBroken


class Judgement(Struct, frozen=True, kw_only=True):
    """The results of judging a timeline."""

    least_clearance: Least
    least_separation: Least
    least_moving_clearance: Least
    path_m: float
    """Metres driven by all robots."""
    breaches: tuple[Breach, ...]
    failure: str | None = None
    """Why the judge failed, which should never happen: then nothing is proved."""

    @property
    def untrue(self) -> frozenset[int]:
        """The robots that recorded an arrival which their poses do not show."""
        return untrue_in(self.breaches)

    @property
    def violations(self) -> dict[str, int]:
        """How often each promise was broken."""
        counts = Counter(breach.broken.invariant for breach in self.breaches)
        return {invariant: counts[invariant] for invariant in INVARIANTS}


def untrue_in(breaches: Iterable[Breach]) -> frozenset[int]:
    """The robots of broken arrivals."""
    return frozenset(each.broken.robot for each in breaches if each.broken.invariant in ARRIVAL)


class Court:
    """All rules that judge one run, and what they have found."""

    def __init__(
        self,
        tolerance: Tolerance,
        *,
        followers_sense: bool,
        further: Sequence[Rule] = (),
        waiting: Sequence[Waiting] = (),
    ) -> None:
        """`further`: rules that need the scenario; `waiting`: those of them whose checks may wait."""
        self._evidence, self._claims = evidence, claims = Evidence(), Claims()
        self._numbers = Numbers()
        self._waiting: tuple[Waiting, ...] = (*waiting, claims)
        self._rules: tuple[Rule, ...] = (
            *further,
            FenceOrder(),
            Formations(evidence, claims),
            Authority(evidence, claims, tolerance, followers_sense=followers_sense),
            Motion(evidence, claims, tolerance),
            Leading(evidence, claims),
            Granting(evidence, claims),
            Epochs(evidence, claims),
            Counting(),
        )
        self._hearing: defaultdict[type, list[Rule]] = defaultdict(list)
        for rule in self._rules:
            for kind in rule.kinds:
                self._hearing[kind].append(rule)
        self._found: dict[tuple[PromiseBroken, float | None], Breach] = {}
        self._epoch = 0

    @property
    def undecided(self) -> int:
        """How many checks wait for entries of other sources."""
        return len(self._claims)

    @property
    def breaches(self) -> tuple[Breach, ...]:
        """All violations found so far, in order of time."""
        return tuple(sorted(self._found.values(), key=lambda breach: breach.t_s))

    def hear(self, source: str, entry: Entry) -> list[Breach]:
        """Process the next entry; returns the violations that are certain now."""
        self._evidence.hear(source, entry)
        found = [*self._claims.hear(source, entry), *self._numbers.hear(source, entry)]
        for rule in self._hearing.get(type(entry.record), ()):
            found += rule.hear(source, entry)
        new = self._note(found) if found else []
        if source == WORLD and isinstance(entry.record, FenceChanged):
            self._forget(entry.record.epoch)
        return new

    def close(self, *, cut_off: bool = False) -> list[Breach]:
        """No entry follows: the violations that were not certain before.

        Args:
            cut_off: the log ends before its run. Checks that wait for another source stay undecided.
        """
        new = [each for rule in self._rules for each in self._note(rule.close())]
        for waiting in () if cut_off else self._waiting:
            new += self._note(waiting.decide())
        return new

    def _forget(self, epoch: int) -> None:
        """Another epoch is in force: forget those before, but for the last one and undecided checks."""
        if epoch != self._epoch:
            self._evidence.forget({self._epoch, epoch} | self._claims.epochs)
            self._epoch = epoch

    def _note(self, found: Iterable[Dated]) -> list[Breach]:
        """Keep new violations: without a length, the same counts once."""
        new: list[Breach] = []
        for t_s, broken in found:
            # Two motions that miss by the same length are two violations.
            key = broken, None if broken.measured_m is None else t_s
            if key not in self._found:
                self._found[key] = Breach(t_s=t_s, broken=broken)
                new.append(self._found[key])
        return new


class Judge:
    """Judges one run as its entries come, in the order of the timeline's lines."""

    def __init__(self, scenario: Scenario) -> None:
        law = scenario.law
        tolerance = Tolerance(
            mu0_m=law.mu0_m,
            heading_error_rad=scenario.drive.heading_error_rad,
            # Other fleets rely on that one, and not on what bodies could do (docs/fleets.md, M1).
            speed_mps_max=scenario.drive.speed_mps,
        )
        self._distances = Distances(scenario)
        truth = Truth(scenario)
        self._court = Court(
            tolerance,
            followers_sense=law.promises_clearance,
            further=(self._distances, Watched(), truth),
            waiting=(truth,),
        )
        self._failure: str | None = None

    @property
    def undecided(self) -> int:
        """How many checks and moves wait for later entries."""
        return self._court.undecided + self._distances.undecided

    def hear(self, source: str, entry: Entry) -> list[Breach]:
        """Process the next entry of the timeline; returns the violations that are certain now."""
        return self._judge(lambda: self._court.hear(source, entry))

    def close(self, *, cut_off: bool = False) -> list[Breach]:
        """No entry follows: the violations that were not certain before; `cut_off`: as `Court.close`."""
        found = self._judge(lambda: self._court.close(cut_off=cut_off))
        self._failure = self._failure or self._distances.unjudged
        return found

    def _judge(self, found: Callable[[], list[Breach]]) -> list[Breach]:
        """What is found; a judge that has failed finds nothing more, and the run has failed."""
        if self._failure is not None:
            return []
        try:
            return found()
        except Exception as error:
            self._failure = sentence_of(error)
            return []

    @property
    def judgement(self) -> Judgement:
        """The results so far."""
        monitor = self._distances.monitor
        return Judgement(
            least_clearance=monitor.least_clearance,
            least_separation=monitor.least_separation,
            least_moving_clearance=monitor.least_moving_clearance,
            path_m=self._distances.path_m,
            breaches=self._court.breaches,
            failure=self._failure,
        )


def judge(
    scenario: Scenario, lines: Iterable[tuple[str, Entry]], *, cut_off: Callable[[], bool] = lambda: False
) -> Judgement:
    """Judge a timeline, given as sources and their entries in the recorder's order.

    `cut_off`: as `Court.close`, asked behind the last line.
    """
    judge = Judge(scenario)
    for source, entry in lines:
        judge.hear(source, entry)
    judge.close(cut_off=cut_off())
    return judge.judgement
