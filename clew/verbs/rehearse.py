"""`clew rehearse`: runs a whole fleet in one process, in virtual time."""

import secrets
from datetime import UTC, datetime
from pathlib import Path

import click

from clew.fleet.folder import RUNS, folder_name, make_folder, make_latest
from clew.verbs.options import AS_JSON, DEPLOYMENT, FAULTS, LAW, ONE_SEED, OUT, SCENARIO, TIME, robots_option
from clew.verbs.say import warn
from protocol.faults.plan import NO_FAULTS
from protocol.faults.plan import load as load_plan


@click.command()
@SCENARIO
@robots_option("Number of robots, instead of the scenario's.")
@ONE_SEED
@LAW
@DEPLOYMENT
@TIME
@FAULTS
@OUT
@AS_JSON
@click.pass_context
def rehearse(
    ctx: click.Context,
    scenario: str,
    *,
    robots: int | None,
    seed: int,
    law: str | None,
    deployment: str | None,
    time_s_max: float | None,
    faults: str | None,
    out: Path | None,
    as_json: bool,
) -> None:
    """Run a whole fleet in this process, in virtual time.

    The same seed gives the same timeline, to the byte. SCENARIO is a name in launch/scenarios/ or a file. The
    run's folder, the summary and the exit code are those of launch/fleet.sh.
    """
    from clew.fleet.summary import report
    from clew.log import timeline
    from clew.rehearsal.processes import check_rehearsable
    from clew.rehearsal.recorded import rehearse as rehearse_into
    from world.judge.verdict import VERDICT_FILE
    from world.scenario.scenario import load

    loaded = load(scenario, robots=robots, law=law, deployment=deployment, time_s_max=time_s_max, seed=seed)
    plan = NO_FAULTS if faults is None else load_plan(faults)
    check_rehearsable(plan, loaded.mission())
    folder = out or RUNS / folder_name(datetime.now(UTC), loaded.name, secrets.token_hex(2))
    make_folder(folder)
    if out is None:
        make_latest(folder)
    verdict = rehearse_into(loaded, seed, folder, lambda said: warn(f"rehearsal: {said}"), plan)
    if as_json:
        click.echo((folder / VERDICT_FILE).read_text(encoding="utf-8"), nl=False)
    else:
        click.echo("\n".join(report(str(folder), timeline.read(folder), verdict)))
    ctx.exit(verdict.exit_code)
