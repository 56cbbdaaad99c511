"""Options that several verbs of the command line take."""

import click

from protocol.frames import ROBOTS_MAX
from protocol.mission import Law
from world.options import DEPLOYMENTS, SEED_MAX

AS_JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON, for programs.")
LAW = click.option(
    "--law", type=click.Choice([law.value for law in Law]), help="The law, instead of the scenario's."
)
DEPLOYMENT = click.option(
    "--deployment",
    type=click.Choice(DEPLOYMENTS),
    help="Free places drawn by the seed, instead of the scenario's.",
)
FAULTS = click.option(
    "--faults", metavar="PLAN", help="What goes wrong on purpose: a name in launch/faults, or a .toml file."
)
ROBOTS = click.IntRange(1, ROBOTS_MAX)
SEED = click.IntRange(0, SEED_MAX)
