"""Options that several verbs of the command line take."""

import click

from clew.fleet.options import DEPLOYMENTS
from protocol.frames import ROBOTS_MAX
from protocol.mission import Law
from protocol.run_settings import SEED_MAX

AS_JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON, for programs.")
LAW = click.option(
    "--law", type=click.Choice([law.value for law in Law]), help="Use this law instead of the scenario's."
)
DEPLOYMENT = click.option(
    "--deployment",
    type=click.Choice(DEPLOYMENTS),
    help="Start at random free places, drawn by the seed, instead of the scenario's places.",
)
FAULTS = click.option(
    "--faults", metavar="PLAN", help="Fault plan: a name in launch/faults/, or a .toml file."
)
ROBOTS = click.IntRange(1, ROBOTS_MAX)
SEED = click.IntRange(0, SEED_MAX)
