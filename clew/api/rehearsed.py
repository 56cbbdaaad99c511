"""A fleet in virtual time, in this process: the same seed and calls give the same run, to the byte."""

import secrets
from collections.abc import Callable, Iterable, Iterator, Sequence
from datetime import UTC, datetime
from operator import index
from pathlib import Path

import msgspec
from msgspec.structs import replace

from clew.api.fleet import Asked, Fleet, ended
from clew.api.paths import path_of
from clew.api.run import EndedRun
from clew.fleet.folder import RUNS, folder_name, new_folder
from clew.log.timeline import is_integer
from clew.rehearsal.processes import check_rehearsable
from clew.rehearsal.recorded import Recorded
from clew.swarm.plans import plan_for
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.fit import check_fits
from protocol.faults.plan import Plan
from protocol.faults.rules import Rule
from protocol.files.reading import understand
from protocol.run_settings import Settings
from world.faults import RunFaults
from world.record.lines import Line
from world.scenario.scenario import Scenario, load

Faults = Iterable[Rule] | str | Path
"""Rules; or a plan, by its name in `launch/faults/` or its file; or `drawn`: the seed draws it."""


def rehearse(
    scenario: str | Path | Scenario = "grove",
    *,
    robots: int | None = None,
    seed: int = 1,
    law: str | None = None,
    deployment: str | None = None,
    time_s_max: float | None = None,
    faults: Faults = (),
    out: Path | str | None = None,
) -> EndedRun:
    """Rehearse a fleet to its end, as `clew rehearse` does; returns the run.

    >>> run = rehearse("grove", robots=3, seed=7)
    >>> run.ok, run.verdict.robots_arrived
    (True, 3)

    Args:
        scenario: a name in `launch/scenarios/` of one fleet, a file, or a scenario.
        robots: how many, instead of the scenario's.
        seed: decides every random draw.
        law: its name, or `FILE.py:NAME`, instead of the scenario's.
        deployment: `random`, instead of the scenario's places.
        time_s_max: simulated time after which the run fails, instead of the scenario's.
        faults: rules, as `clew.drop("ahead", p=0.3)`; or a plan: a name in `launch/faults/`, or a file; or
            `drawn`: the seed draws them.
        out: the run's folder, new or empty; default: a new one in `runs/`.

    Raises:
        UsageError: it cannot be rehearsed as asked.
    """
    asked = asked_of(
        scenario,
        robots=robots,
        seed=seed,
        law=law,
        deployment=deployment,
        time_s_max=time_s_max,
        faults=faults,
        out=out,
    )
    with RehearsedFleet(asked) as fleet:
        return fleet.finish()


def asked_of(
    scenario: str | Path | Scenario,
    *,
    robots: int | None,
    seed: int,
    faults: Faults,
    out: Path | str | None,
    law: str | None = None,
    deployment: str | None = None,
    time_s_max: float | None = None,
) -> Asked:
    """What was asked for, with the run's folder, which is made when the fleet begins.

    Raises:
        UsageError: there is no such scenario, or the arguments do not fit it.
    """
    if callable(law):
        raise UsageError("law: must be a name; clew.register_law gives one to a function")
    settings = understand({"seed": _integer("seed", seed)}, Settings, "clew")
    robots = None if robots is None else _integer("robots", robots)
    if isinstance(scenario, str | Path):
        scenario = load(
            str(scenario),
            robots=robots,
            law=law,
            deployment=deployment,
            time_s_max=time_s_max,
            seed=settings.seed,
        )
    elif not isinstance(scenario, Scenario):
        raise UsageError(f"scenario: must be a name, a file or a scenario, got {scenario!r}")
    elif law is not None or deployment is not None:
        raise UsageError("law and deployment are for scenarios that are given by their names")
    elif robots is not None or time_s_max is not None:
        raw = msgspec.to_builtins(scenario)
        raw["fleet"]["robots"] = scenario.fleet.robots if robots is None else robots
        raw["time"]["time_s_max"] = scenario.time.time_s_max if time_s_max is None else time_s_max
        scenario = understand(raw, Scenario, scenario.name)
    folder = _new_folder(scenario) if out is None else path_of("out", out, "a folder")
    rules = _rules(faults, scenario, settings.seed)
    return Asked(scenario=scenario, seed=settings.seed, folder=folder, rules=rules)


def _rules(faults: object, scenario: Scenario, seed: int) -> tuple[Rule, ...]:
    if isinstance(faults, str | Path):
        plan = plan_for(str(faults), robots=scenario.fleet.robots, seed=seed)
        check_fits(plan, robots=scenario.fleet.robots, source=str(faults))
        return plan.rules
    given = tuple(faults) if isinstance(faults, Iterable) else (faults,)
    for each in given:
        if not isinstance(each, Rule):
            raise UsageError(
                f"faults: must be a plan, or a list of rules such as clew.drop(p=0.3), got {faults!r}"
            )
    return given


def _integer(name: str, value: object) -> int:
    """Any integer."""
    if not is_integer(value):
        raise UsageError(f"{name}: must be an integer, got {value!r}")
    return index(value)


def _new_folder(scenario: Scenario) -> Path:
    return RUNS / folder_name(datetime.now(UTC), scenario.name, secrets.token_hex(2))


class RehearsedFleet(Fleet):
    """A fleet in virtual time."""

    def __init__(self, asked: Asked) -> None:
        self._recorded: Recorded | None = None
        self._ticks: Iterator[float] = iter(())
        self._heard = 0
        self._is_over = False
        super().__init__(asked)

    @property
    def is_over(self) -> bool:
        """Whether the run has ended and is judged."""
        return self._is_over

    @property
    def lines(self) -> Sequence[Line]:
        """All entries up to now."""
        return [] if self._recorded is None else self._recorded.rehearsal.entries

    @property
    def now_s(self) -> float:
        """Simulated time."""
        return 0.0 if self._recorded is None else self._recorded.rehearsal.world.now_s

    def _start(self, plan: Plan) -> None:
        asked, folder = self.asked, self.asked.folder
        check_rehearsable(plan, asked.scenario.mission(), "faults")
        self._faults = RunFaults(plan, asked.seed, robots=asked.scenario.fleet.robots)
        with new_folder(folder, is_latest=folder.parent == RUNS):
            self._recorded = Recorded(asked.scenario, asked.seed, folder, plan, lambda _: None)
        self._ticks = self._recorded.ticks()

    def _advance(self) -> None:
        if next(self._ticks, None) is None and self._recorded is not None and not self._is_over:
            self._is_over = True
            if self._recorded.rehearsal.world.judgement is not None:  # else a bug of ours ended it
                self._recorded.judge()

    def _deadline(self, timeout_s: float) -> Callable[[], str | None]:
        began_s = self.now_s

        def passed() -> str | None:
            waited_s = self.now_s - began_s
            return None if waited_s <= timeout_s else f"{waited_s:.1f} simulated s have passed"

        return passed

    @property
    def _ending(self) -> str:
        verdict = self.run.verdict
        return "a core of ours failed" if verdict is None else verdict.reason

    def _give(self, rule: Rule) -> tuple[str, tuple[Rule, ...]]:
        """The world of a live run makes the same rules of it, and refuses the same."""
        assert self._recorded is not None, "nothing is given before the start"
        rehearsal = self._recorded.rehearsal
        for source, entry in rehearsal.entries[self._heard :]:
            self._faults.hear(source, entry)
        self._heard = len(rehearsal.entries)
        name, rules = self._faults.resolve(rule, now_s=self.now_s, for_s=None)
        plan = replace(rehearsal.plan, rules=(*rehearsal.plan.rules, *rules))
        check_rehearsable(plan, self.asked.scenario.mission(), "faults")
        rehearsal.turn_to(plan)
        self._faults.take()
        return name, rules

    def _end(self, name: str) -> None:
        assert self._recorded is not None, "nothing is given before the start"
        rehearsal = self._recorded.rehearsal
        rules = tuple(ended(rule, self.now_s) if rule.name == name else rule for rule in rehearsal.plan.rules)
        rehearsal.turn_to(replace(rehearsal.plan, rules=rules))

    def close(self) -> None:
        """Stop, if the run goes on."""
        if self._recorded is None:
            return
        try:
            if not self._is_over:
                self._recorded.rehearsal.stop(ExitCode.TERMINATED)
            while not self._is_over:
                self._advance()
        finally:
            self._recorded.close()
