"""`clew shrink`: the least of a fault plan that still makes a run fail in the same way."""

from pathlib import Path

import click
import msgspec

from lab import timeline
from lab.campaign import CAMPAIGN_FILE, Campaign
from lab.campaign_episode import SWARM
from lab.options import SEED
from lab.plan_text import FAULTS_FILE, plan_text
from lab.shrink import Case, Failure, failure_of, shrink
from lab.swarm import Mode, draw
from lab.toml_text import toml_text
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.faults.plan import load as load_plan
from protocol.reading import understand
from world.recorder import EVENTS_FILE
from world.scenario import Scenario

SHRUNK_FOLDER, WORLD_FILE = "shrunk", "world.toml"


@click.command("shrink")
@click.argument("run", type=click.Path(path_type=Path))
@click.option("--seed", type=SEED, help="Of a swarm campaign: which episode.")
@click.option("--out", type=click.Path(path_type=Path), help="Where to; default: shrunk/ in RUN's folder.")
@click.pass_context
def shrink_verb(ctx: click.Context, run: Path, *, seed: int | None, out: Path | None) -> None:
    """Cut the fault plan of a failing run to the least that still fails in the same way.

    RUN is the folder of a rehearsed run, or of a campaign with --faults swarm and then --seed says which
    episode. Prints the plan and the line that replays it. Exit code: 0 shrunk, 1 the run does not fail,
    2 it cannot be done as asked.
    """
    case = _case_of_run(run) if (run / EVENTS_FILE).exists() else _case_of_episode(run, seed)
    failure = failure_of(case)
    if failure is None:
        click.echo(f"{run}: does not fail when it is rehearsed again", err=True)
        ctx.exit(ExitCode.FAILED)
    click.echo(f"shrink: {failure.way}: {failure.reason}", err=True)
    least = shrink(case, _Trials(failure))
    click.echo(plan_text(least.plan), nl=False)
    click.echo(_write(least, out or run / SHRUNK_FOLDER))


class _Trials:
    """Says of a case whether it fails in the same way, and tells the user how far it is."""

    def __init__(self, failure: Failure) -> None:
        self._failure = failure
        self._count = 0

    def __call__(self, case: Case) -> bool:
        found = failure_of(case)
        self._count += 1
        same = found is not None and found.way == self._failure.way
        if same:
            rules, robots = len(case.plan.rules), case.scenario.fleet.robots
            click.echo(f"shrink: after {self._count} rehearsals: {rules} rules, {robots} robots", err=True)
        return same


def _case_of_run(run: Path) -> Case:
    header = timeline.read(run).header
    if header.speed is not None:
        raise UsageError(f"{run}: is a live run; only rehearsals can be repeated with less")
    plan_path = run / FAULTS_FILE
    if not plan_path.exists():
        raise UsageError(f"{run}: no fault plan in it: there is nothing to cut")
    scenario = understand(header.scenario, Scenario, str(run))
    return Case(scenario=scenario, seed=header.seed, plan=load_plan(str(plan_path)))


def _case_of_episode(campaign: Path, seed: int | None) -> Case:
    path = campaign / CAMPAIGN_FILE
    try:
        faults = msgspec.json.decode(path.read_bytes(), type=Campaign).faults
    except (OSError, msgspec.MsgspecError) as error:
        raise UsageError(f"{campaign}: neither a run nor a campaign of this version: {error}") from error
    if faults != SWARM:
        raise UsageError(f"{campaign}: has no --faults {SWARM}; rehearse the episode, and shrink that run")
    if seed is None:
        raise UsageError(f"{campaign}: is a campaign; --seed has to say which episode")
    swarm = draw(seed)
    return Case(
        scenario=swarm.scenario,
        seed=seed,
        plan=swarm.plan,
        quiet_s=swarm.quiet_s if swarm.mode is Mode.LIVENESS else None,
        outside=swarm.outside,
    )


def _write(case: Case, out: Path) -> str:
    """Write the case down; returns the line that replays it."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        world = toml_text(msgspec.to_builtins(case.scenario))
        (out / WORLD_FILE).write_text(world, encoding="utf-8")
        (out / FAULTS_FILE).write_text(plan_text(case.plan), encoding="utf-8")
    except OSError as error:
        raise UsageError(f"cannot write into {out}: {error.strerror}") from error
    faults = out / FAULTS_FILE
    return f"./launch/clew rehearse {out / WORLD_FILE} --faults {faults} --seed {case.seed}"
