"""A fleet of real processes: started by the launcher, followed by its log, with faults by its world. A shell.

Rule 1: each fleet has its own folder, and its own private folder with its sockets; so many may run at once.
Rule 2: it waits for entries in the log. A wait ends when simulated time has passed its limit and a grace,
        since live processes notice a loss by the wall clock; or when far more wall-clock time has passed than
        a machine should take. Then it says how late the machine was.
Rule 3: at `max` it is held while nobody waits, at most `AHEAD_S` beyond what was looked at: it would be over
        before a test that gets no processor time has given its fault.
Rule 4: when it is closed, no process and no socket is left behind. If one was, it is killed, and that is an
        error.
"""

import contextlib
import math
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

from msgspec import structs

from clew.api.fleet import Asked, Fleet, WaitFailedError
from clew.api.rehearsed import Faults, RehearsedFleet, asked_of
from clew.fleet.folder import RUNS, make_latest
from clew.fleet.live import LAUNCHER, Launched, our_environment
from clew.fleet.options import speed_of
from clew.fleet.runs import verdict_in
from clew.log.follow import Follower, look
from protocol import laws
from protocol.errors import UsageError
from protocol.faults.manual_faults import EndRequest, FaultRequest, GoRequest, request_fault
from protocol.faults.plan import Plan
from protocol.faults.plan_text import FAULTS_FILE, plan_text
from protocol.faults.rules import Rule
from protocol.files.writing import write_whole
from protocol.plain import plain
from protocol.run_settings import SCENARIO_FILE
from protocol.timeline import PoseSampled
from world.judge.verdict import Verdict
from world.record.lines import Line
from world.record.recorder import EVENTS_FILE
from world.record.run_files import scenario_files
from world.scenario.scenario import Scenario

Speed = float | Literal["max"]

GRACE_WALL_S = 3.0  # a lost process is noticed after its lease of 1 s, and on a loaded machine later
WALL_S = 60.0  # to start, to be judged and to end on a loaded machine
SLOWEST = 0.5  # simulated s per wall-clock s of `max`, at least: 50 robots on two cores reach 1
LOOK_S = 0.02  # between two reads of the log: a world writes every 0.1 s
AHEAD_S = 0.5  # simulated: it asks every 0.02 s, so fleets of up to 25 times real time are not slowed down
LATE = 4.0  # so many times what a wait takes on an idle machine
SAID_LINES = 3  # of stderr: the refusal is the last


def launch(
    scenario: str | Path | Scenario = "grove",
    *,
    robots: int | None = None,
    seed: int = 1,
    law: str | None = None,
    deployment: str | None = None,
    time_s_max: float | None = None,
    speed: Speed = 1.0,
    faults: Faults = (),
    out: Path | str | None = None,
    stage: Literal["live", "rehearsal"] = "live",
) -> Fleet:
    """A fleet to wait for and to break, which begins at the first wait; `with` ends it.

    >>> with launch("grove", robots=3, stage="rehearsal") as fleet:
    ...     planned = fleet.until("step.planned", step=2, timeout_s=20)
    ...     with fleet.partition([1, 2], [3]):
    ...         view = fleet.until("view.proposed")
    ...     run = fleet.finish()
    >>> planned.step, run.ok
    (2, True)

    Args:
        scenario: as in `rehearse`.
        robots: as in `rehearse`.
        seed: as in `rehearse`.
        law: as in `rehearse`.
        deployment: as in `rehearse`.
        time_s_max: as in `rehearse`.
        speed: of live fleets, times real time; `max`: as fast as the robots answer.
        faults: as in `rehearse`.
        out: as in `rehearse`.
        stage: `live`, real processes; or `rehearsal`, virtual time, which passes only in waits.

    Raises:
        UsageError: it cannot run as asked.
    """
    if stage not in ("live", "rehearsal"):
        raise UsageError(f"stage: must be live or rehearsal, got {stage!r}")
    check_speed(speed)
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
    return RehearsedFleet(asked) if stage == "rehearsal" else LaunchedFleet(asked, speed)


def check_speed(speed: Speed) -> None:
    """Refuse a speed that no live fleet can have, also where a rehearsal has no use for it.

    Raises:
        UsageError: it is neither `max` nor a number of a possible size.
    """
    try:
        speed_of(str(speed))
    except UsageError as error:
        raise UsageError(f"speed: {error}") from error


class LaunchedFleet(Fleet):
    """A fleet of real processes."""

    def __init__(self, asked: Asked, speed: Speed = 1.0) -> None:
        laws.check(asked.scenario.law.law, in_processes=True)
        self.speed = speed
        self._launched: Launched | None = None
        self._follower = Follower(asked.folder.absolute() / EVENTS_FILE)
        self._lines: list[Line] = []
        self._now_s = 0.0
        super().__init__(replace(asked, folder=asked.folder.absolute()))

    @property
    def is_over(self) -> bool:
        """Whether its launcher has ended."""
        return self._launched is not None and self._launched.has_ended(0.0)

    @property
    def lines(self) -> Sequence[Line]:
        """All entries up to now."""
        while self.has_begun and (news := look(self._follower)):
            self._lines += news.lines
            self._now_s = max((self._now_s, *(entry.t_s for _, entry in news.lines)))
        return self._lines

    @property
    def now_s(self) -> float:
        """The newest simulated time in the log."""
        return self._now_s

    def _start(self, plan: Plan) -> None:
        asked = self.asked
        speed = str(self.speed)
        with tempfile.TemporaryDirectory(prefix="clew-asked.") as folder:
            files = {**scenario_files(asked.scenario), FAULTS_FILE: plan_text(plan).encode()}
            paths = {name: Path(folder) / name for name in files}
            for name, text in files.items():
                write_whole(paths[name], text)
            options = ["--seed", str(asked.seed), "--speed", speed, "--out", str(asked.folder), "--quiet"]
            if self.speed == "max":
                options += ["--held"]
            if plan.rules:
                options += ["--faults", str(paths[FAULTS_FILE])]
            command = [*LAUNCHER, str(paths[SCENARIO_FILE]), *options]
            self._launched = Launched(command, our_environment())
            self._wait_for_start()
        if asked.folder.parent == RUNS.absolute():
            make_latest(asked.folder)

    def _wait_for_start(self) -> None:
        """Wait until the bodies are placed: before, no fault can be given."""
        passed = self._deadline(math.inf)
        while not any(isinstance(entry.record, PoseSampled) for _, entry in self.lines):
            if self.is_over:
                raise WaitFailedError(f"the fleet did not start: {self._ending}")
            if (why := passed()) is not None:
                raise WaitFailedError(f"the fleet did not start: {why}")
            self._advance()

    def _advance(self) -> None:
        assert self._launched is not None, "waited for before the start"
        if self.speed == "max":
            with contextlib.suppress(UsageError):  # it has not begun, is over, or its world is being replaced
                request_fault(self.asked.folder, GoRequest(for_s=AHEAD_S))
        self._launched.has_ended(LOOK_S)

    def _deadline(self, timeout_s: float) -> Callable[[], str | None]:
        """Rule 2."""
        began_s, began_wall_s = self.now_s, time.monotonic()
        speed = SLOWEST if self.speed == "max" else self.speed
        grace_s = (
            0.0 if self.speed == "max" else GRACE_WALL_S * speed
        )  # of `max`, time stands still meanwhile
        needed_wall_s = 0.0 if math.isinf(timeout_s) else timeout_s / speed
        wall_s_max = WALL_S + LATE * needed_wall_s

        def passed() -> str | None:
            waited_s, wall_s = self.now_s - began_s, time.monotonic() - began_wall_s
            if waited_s <= timeout_s + grace_s and wall_s <= wall_s_max:
                return None
            late_s = wall_s - waited_s / speed
            load = f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores"
            late = f"the machine was {late_s:.1f} s late, {load}" if late_s > GRACE_WALL_S else load
            return f"{waited_s:.1f} simulated s in {wall_s:.1f} s of wall clock have passed ({late})"

        return passed

    @property
    def _ending(self) -> str:
        if (verdict := verdict_in(self.asked.folder, Verdict)) is not None:
            return verdict.reason
        assert self._launched is not None, "ended before the start"
        return plain(" / ".join(self._launched.end().said[-SAID_LINES:])) or "it said nothing"

    def _give(self, rule: Rule) -> tuple[str, tuple[Rule, ...]]:
        name = request_fault(self.asked.folder, FaultRequest(rule=rule))
        return name, (structs.replace(rule, name=name, from_s=max(rule.from_s, self.now_s)),)

    def _end(self, name: str) -> None:
        request_fault(self.asked.folder, EndRequest(name=name))

    def close(self) -> None:
        """Stop, if the run goes on (rule 4).

        Raises:
            WaitFailedError: it had to be killed, or has left something behind.
        """
        if self._launched is None:
            return
        ended = self._launched.end()
        if ended.code is None or ended.leftovers:
            how = "had to be killed" if ended.code is None else f"ended with {ended.code}"
            raise WaitFailedError(
                f"the fleet {how} and left behind: {', '.join(ended.leftovers) or 'nothing'}"
            )
