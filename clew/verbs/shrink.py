"""`clew shrink`: cuts a fault plan to a smallest part with which a run still fails in the same way."""

import shlex
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING

import click
import msgspec

from clew.fleet.folder import make_folder
from clew.verbs.options import PATH, RUN_FOLDER, SEED
from clew.verbs.say import many, to_copy, warn
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import Plan
from protocol.faults.plan_text import FAULTS_FILE, plan_text
from protocol.files.opening import MADE_BYTES_MAX, read_bytes
from protocol.files.reading import understand
from protocol.files.writing import write_whole
from protocol.law_files import look_in

if TYPE_CHECKING:
    from clew.campaign.failures import Case, Failure

SHRUNK_FOLDER, WORLD_FILE = "shrunk", "world.toml"


@click.command("shrink")
@click.argument("run", type=RUN_FOLDER)
@click.option("--seed", type=SEED, help="Episode of a swarm campaign.")
@click.option(
    "--out",
    type=PATH,
    help="Folder for the result; default: shrunk/ in RUN, then shrunk-2/, ...",
)
@click.pass_context
def shrink_verb(ctx: click.Context, run: Path, *, seed: int | None, out: Path | None) -> None:
    """Cut the fault plan of a failed run down to what still makes it fail in the same way.

    RUN is the folder of a rehearsed run, or of a swarm campaign; then --seed chooses the episode. The verb
    prints the plan and the command line that replays it. An earlier result stays: the next one is in
    shrunk-2/. Exits with 1 when the run did not fail, or fails in another way when it is rehearsed again.
    """
    from clew.campaign.failures import failure_of
    from clew.campaign.shrink import shrink
    from world.record.recorder import EVENTS_FILE

    is_run = (run / EVENTS_FILE).exists()
    if is_run and seed is not None:
        raise UsageError(f"{run}: is a run; --seed chooses an episode of a campaign")
    case, recorded = _run(run) if is_run else _episode(run, seed)
    if recorded is None:
        warn(f"{run}: did not fail")
        ctx.exit(ExitCode.FAILED)
    if (again := failure_of(case)) is None or again.way != recorded.way:
        now = "does not fail" if again is None else f"fails in another way: {again.reason}"
        warn(f"{run}: failed: {recorded.reason}; rehearsed again it {now}")
        ctx.exit(ExitCode.FAILED)
    warn(f"shrink: {recorded.sentence}")
    # `runs/latest` is soon another run: the first replay by the printed line makes it one.
    kept = run.parent / run.readlink() if run.is_symlink() else run
    folder = out or _next(kept / SHRUNK_FOLDER)
    make_folder(folder)  # fail before the work, not after it
    least = shrink(case, _Trials(recorded))
    click.echo(plan_text(least.plan), nl=False)
    click.echo(to_copy(_write(least, folder)))


class _Trials:
    """Tests whether a case still fails in the same way, and reports progress."""

    def __init__(self, failure: "Failure") -> None:
        self._failure = failure
        self._count = 0

    def __call__(self, case: "Case") -> bool:
        from clew.campaign.failures import failure_of

        found = failure_of(case)
        self._count += 1
        same = found is not None and found.way == self._failure.way
        if same:
            left = f"{many(len(case.plan.rules), 'rule')}, {many(case.scenario.fleet.robots, 'robot')}"
            click.echo(f"shrink: after {many(self._count, 'rehearsal')}: {left}", err=True)
        return same


def _run(run: Path) -> "tuple[Case, Failure | None]":
    """A rehearsed run, and how it failed."""
    from clew.campaign.failures import Case, failure_in
    from clew.fleet.runs import verdict_in
    from clew.log import timeline
    from world.judge.verdict import Verdict
    from world.scenario.scenario import Scenario

    read = timeline.read(run)
    look_in(run)
    header = read.header
    if header.speed is not None:
        raise UsageError(f"{run}: is a live run; only rehearsals can be shrunk")
    if header.faults is None:
        raise UsageError(f"{run}: has no fault plan to cut")
    if (verdict := verdict_in(run, Verdict)) is None:
        raise UsageError(f"{run}: has no readable verdict that says how it failed")
    case = Case(
        scenario=understand(header.scenario, Scenario, str(run)),
        seed=header.seed,
        plan=understand(header.faults, Plan, str(run)),
    )
    return case, failure_in(read, verdict)


def _episode(folder: Path, seed: int | None) -> "tuple[Case, Failure | None]":
    """An episode of a swarm campaign, and how it failed."""
    from clew.campaign.campaign import CAMPAIGN_FILE, Campaign
    from clew.campaign.episode import SWARM
    from clew.campaign.failures import Case, failure_of_outcome
    from clew.log.log import fleets_in
    from clew.swarm.futures import draw_future, read_branches
    from clew.swarm.swarm import Mode, draw
    from world.record.recorder import EVENTS_FILE

    try:
        campaign = msgspec.json.decode(read_bytes(folder / CAMPAIGN_FILE, MADE_BYTES_MAX), type=Campaign)
    except (FileNotFoundError, NotADirectoryError) as error:
        if fleets_in(folder):
            raise UsageError(f"{folder}: has several fleets; only a run with one can be shrunk") from error
        neither = f"neither a run (no {EVENTS_FILE}) nor a campaign (no {CAMPAIGN_FILE})"
        raise UsageError(f"{folder}: {neither}") from error
    except (OSError, msgspec.MsgspecError) as error:
        raise UsageError(f"{folder}: no campaign of this version: {_plainly(error)}") from error
    if campaign.faults != SWARM:
        raise UsageError(f"{folder}: is no swarm campaign; rehearse the episode and shrink that run")
    if seed is None:
        raise UsageError(f"{folder}: is a campaign; --seed must choose an episode")
    outcome = next((each for each in campaign.episodes if each.seed == seed), None)
    if outcome is None:
        raise UsageError(f"{folder}: has not played seed {seed}")
    swarm = draw_future(seed, read_branches(outcome.branches)) if outcome.branches else draw(seed)
    case = Case(
        scenario=swarm.scenario,
        seed=seed,
        plan=swarm.plan,
        quiet_s=swarm.quiet_s if swarm.mode is Mode.LIVENESS else None,
        outside=swarm.outside,
    )
    return case, failure_of_outcome(outcome)


def _plainly(error: OSError | msgspec.MsgspecError) -> str:
    """The message of an error, without its number and path."""
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


def _next(folder: Path) -> Path:
    """This folder, or if it exists the first free one of folder-2, folder-3, ..."""
    numbered = (folder.with_name(f"{folder.name}-{number}") for number in count(2))
    return next(path for path in chain([folder], numbered) if not path.exists())


def _write(case: "Case", out: Path) -> str:
    """Write the case; returns the command line that replays it."""
    from world.record.run_files import scenario_files

    try:
        files = {**scenario_files(case.scenario, WORLD_FILE), FAULTS_FILE: plan_text(case.plan).encode()}
        for name, text in files.items():
            write_whole(out / name, text)
    except OSError as error:
        raise UsageError(f"cannot write into {out}: {error.strerror}") from error
    world_path, plan_path = str(out / WORLD_FILE), str(out / FAULTS_FILE)
    return shlex.join(
        ["./launch/clew", "rehearse", world_path, "--faults", plan_path, "--seed", str(case.seed)]
    )
