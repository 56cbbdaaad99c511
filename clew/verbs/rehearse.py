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
from protocol.errors import UsageError


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
    from world.scenario.fleets import has_several, load_fleets
    from world.scenario.scenario import load

    if has_several(scenario):
        if deployment is not None:
            raise UsageError("--deployment: is for a scenario with one fleet")
        shared = load_fleets(scenario, robots=robots, law=law, time_s_max=time_s_max)
        name, missions = shared.name, [each.mission() for each in shared.scenarios().values()]
    else:
        loaded = load(
            scenario, robots=robots, law=law, deployment=deployment, time_s_max=time_s_max, seed=seed
        )
        shared, name, missions = None, loaded.name, [loaded.mission()]
    plan = plan_for(faults, robots=min(each.robots for each in missions), seed=seed)
    for mission in missions:
        check_rehearsable(plan, mission, faults)
    folder = out or RUNS / folder_name(datetime.now(UTC), name, secrets.token_hex(2))
    say = _say_nothing if quiet else _say
    said: Iterable[str]
    with new_folder(folder, is_latest=out is None):
        if shared is None:
            verdict = rehearse_into(loaded, seed, folder, say, plan)
            code, said = verdict.exit_code, report(str(folder), timeline.read(folder), verdict)
        else:
            together = rehearse_fleets(shared, seed, folder, say, plan)
            code, said = together.exit_code, report_together(str(folder), together)
    if as_json:
        click.echo((folder / VERDICT_FILE).read_text(encoding="utf-8"), nl=False)
    else:
        click.echo("\n".join(said))
    ctx.exit(code)


def _say(said: str) -> None:
    warn(f"rehearsal: {said}")


def _say_nothing(_: str) -> None:
    """With `--quiet`, the timeline is all that has it."""
