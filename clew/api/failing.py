"""What a failing test says of its fleet: what broke first, its seed, the faults that matter, the replay.

Rule 1: a test is played again in rehearsals with fewer faults, as long as it fails at the same line with the
        same exception. So the plan that is left holds the faults that matter to the test, whatever it claims.
Rule 2: so is a live test; if it does not fail in a rehearsal with all its faults, it keeps them all, and the
        message says so: its cause is then in what differs live (docs/chaos.md).
"""

import shlex
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from traceback import walk_tb

from clew.api.fleet import Fleet
from clew.api.rehearsed import RehearsedFleet
from clew.campaign.shrink import fewest
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import Plan
from protocol.faults.plan_text import plan_text
from protocol.files.writing import write_whole
from protocol.plain import plain
from protocol.run_settings import SCENARIO_FILE

TRIALS_MAX = 24  # a rehearsal of a few robots takes half a second
PLAN_FILE, TRIAL = "shrunk.toml", "trial"


@dataclass(frozen=True, slots=True)
class Test:
    """A test that has failed."""

    path: Path
    """Its file."""
    replay: str
    """The command line that runs it again."""
    error: BaseException
    mistake: str
    """What the test itself does wrong, by its error; empty: it may be right."""
    play: Callable[[frozenset[int], Path], tuple[Fleet, BaseException | None]] | None
    """Runs the test again without these faults, in this folder; returns its closed fleet and how it failed.
    None: it is not to be played again.
    """


def told(test: Test, fleet: Fleet) -> Iterator[str]:
    """The lines about the fleet of a failed test; stops it if it goes on."""
    if not fleet.has_begun:
        yield "the fleet had not begun"
        return
    fleet.close()
    folder = fleet.asked.folder
    yield f"what broke first: {_first(test, fleet)}"
    if isinstance(test.error, UsageError) and _kept_all(fleet):
        yield f"run the test again:      {test.replay}"
        return
    yield f"seed: {fleet.asked.seed}"
    plan, note = _least(test, fleet)
    yield f"faults: {note}"
    if plan.rules:
        yield from (f"    {line}" for line in plan_text(plan).splitlines() if line)
    write_whole(folder / PLAN_FILE, plan_text(plan).encode())
    rehearse = [
        sys.executable,
        "-m",
        "clew.cli",
        "rehearse",
        str(folder / SCENARIO_FILE),
        "--seed",
        str(fleet.asked.seed),
    ]
    if plan.rules:
        rehearse += ["--faults", str(folder / PLAN_FILE)]
    yield f"run the test again:      {test.replay}"
    yield f"rehearse its fleet:      {shlex.join(rehearse)}"
    yield f"page:                    {fleet.run.report()}"


def _kept_all(fleet: Fleet) -> bool:
    """Whether nothing went wrong in the run. That we have ended it did not go wrong."""
    verdict = fleet.run.verdict
    return verdict is not None and (verdict.ok or verdict.exit_code == ExitCode.TERMINATED)


def _first(test: Test, fleet: Fleet) -> str:
    """The first thing that went wrong in the run, or in the test."""
    if not _kept_all(fleet):
        verdict = fleet.run.verdict
        return "the run has no verdict" if verdict is None else plain(verdict.reason)
    if test.mistake:
        return f"nothing in the fleet: {test.mistake}"
    return f"the test's own claim, at t={fleet.now_s:.1f} s; until then the fleet kept all promises"


def _least(test: Test, fleet: Fleet) -> tuple[Plan, str]:
    """The faults that matter, and what is known of them (rules 1 and 2)."""
    if (unsought := _unsought(test, fleet)) is not None:
        return fleet.plan, unsought
    play = test.play
    assert play is not None, "_unsought has said so"
    trials, folders, plans = count(1), fleet.asked.folder.parent, {frozenset[int](): fleet.plan}

    def fails(kept: list[int]) -> bool:
        without = frozenset(range(1, fleet.given_count + 1)) - frozenset(kept)
        if (trial := next(trials)) > TRIALS_MAX:
            return False
        folder = folders / f"{TRIAL}-{fleet.asked.folder.name}-{trial}"
        again, error = play(without, folder)
        plans[without] = again.plan
        shutil.rmtree(folder, ignore_errors=True)
        return _is_same(test, error)

    everything = list(range(1, fleet.given_count + 1))
    if not fails(everything):
        again = "when it is played again" if isinstance(fleet, RehearsedFleet) else "when it is rehearsed"
        return fleet.plan, f"all that were given; the test does not fail in the same way {again}"
    kept = fewest(everything, fails)
    rehearsed = "" if isinstance(fleet, RehearsedFleet) else ", rehearsed"
    plan = plans[frozenset(everything) - frozenset(kept)]
    if not kept:
        return plan, f"it fails without any{rehearsed}"
    if not plan.rules:
        return plan, "what matters was refused"
    return plan, f"{len(kept)} of {len(everything)} that were given matter{rehearsed}:"


def _unsought(test: Test, fleet: Fleet) -> str | None:
    """Why the test is not played again to find the faults that matter; None: it is."""
    if fleet.given_count == 0:
        return "none were given"
    if not fleet.plan.rules:
        return "all that were given were refused"
    if test.play is None:
        return "all that were given; --clew-no-shrink leaves out the search for those that matter"
    return None


def _is_same(test: Test, error: BaseException | None) -> bool:
    """Whether the test has failed at the same line with the same exception."""
    return error is not None and (type(error), _line(test, error)) == (
        type(test.error),
        _line(test, test.error),
    )


def _line(test: Test, error: BaseException) -> int | None:
    """The line of the test's own file that led to the exception."""
    lines = [
        line for frame, line in walk_tb(error.__traceback__) if Path(frame.f_code.co_filename) == test.path
    ]
    return lines[-1] if lines else None
