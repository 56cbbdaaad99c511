"""`clew rehearse`: runs a whole fleet in one process, in virtual time."""

import secrets
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

import click

from clew.fleet.folder import RUNS, folder_name, new_folder
from clew.verbs.options import (
    AS_JSON,
    DEPLOYMENT,
    FAULTS,
    LAW,
    ONE_SEED,
    OUT,
    QUIET,
    SCENARIO,
    TIME,
    robots_option,
)
from clew.verbs.say import warn


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
@QUIET
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
    quiet: bool,
) -> None:
    """Run a whole fleet in this process, in virtual time.

    The same seed gives the same timeline, to the byte. SCENARIO is a name in launch/scenarios/ or its folder
    fleets/, a TOML file or a scene (JSON); default: grove. The run's folder and the summary are as of `clew
    run`. With several fleets, the folder has one for each of them, and options apply to each.

    Exit code: 0 all promises kept, 1 the run failed or broke a promise, 2 cannot run as asked, 130 Ctrl-C,
    143 SIGTERM, 129 SIGHUP.
    """
    from clew.fleet.summary import report
    from clew.fleet.together import report_together
    from clew.log import timeline
    from clew.rehearsal.fleets import rehearse_fleets
    from clew.rehearsal.processes import check_rehearsable
    from clew.rehearsal.recorded import rehearse as rehearse_into
    from clew.swarm.plans import plan_for
    from world.judge.verdict import VERDICT_FILE
    from world.scenario.fleets import SharedGround, load_any

    loaded = load_any(
        scenario, robots=robots, law=law, deployment=deployment, time_s_max=time_s_max, seed=seed
    )
    fleets = loaded.scenarios().values() if isinstance(loaded, SharedGround) else (loaded,)
    missions = [each.mission() for each in fleets]
    plan = plan_for(faults, robots=min(each.robots for each in missions), seed=seed)
    for mission in missions:
        check_rehearsable(plan, mission, faults)
    folder = out or RUNS / folder_name(datetime.now(UTC), loaded.name, secrets.token_hex(2))
    say = _say_nothing if quiet else _say
    said: Iterable[str]
    with new_folder(folder, is_latest=out is None):
        if isinstance(loaded, SharedGround):
            together = rehearse_fleets(loaded, seed, folder, say, plan)
            code, said = together.exit_code, report_together(str(folder), together)
        else:
            verdict = rehearse_into(loaded, seed, folder, say, plan)
            code, said = verdict.exit_code, report(str(folder), timeline.read(folder), verdict)
    if as_json:
        click.echo((folder / VERDICT_FILE).read_text(encoding="utf-8"), nl=False)
    else:
        click.echo("\n".join(said))
    ctx.exit(code)


def _say(said: str) -> None:
    warn(f"rehearsal: {said}")


def _say_nothing(_: str) -> None:
    """With `--quiet`, the timeline is all that has it."""
