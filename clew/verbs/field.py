"""`clew field`: a random obstacle world as a scene, on stdout."""

import json

import click

from clew.fields.field import DENSITY, ROBOT_RADIUS_M, SIZE_M, WIDTH_RADII, Field, Kind, scene
from clew.verbs.options import SEED
from protocol.files.reading import understand


@click.command()
@click.argument("kind", type=click.Choice([kind.value for kind in Kind]))
@click.option("--seed", type=SEED, default=1, show_default=True, help="Decides every random draw.")
@click.option(
    "--density",
    type=float,
    default=DENSITY,
    show_default=True,
    help="Share of the ground under obstacles, as near as it gets; corridors have none.",
)
@click.option(
    "--least-width",
    "least_width_m",
    type=float,
    help=f"Between obstacles (0: they may overlap), or of corridors, in m; default: {WIDTH_RADII:g} radii.",
)
@click.option(
    "--robot-radius",
    "robot_radius_m",
    type=float,
    default=ROBOT_RADIUS_M,
    show_default=True,
    help="In m; obstacles are drawn in its measure.",
)
@click.option(
    "--size",
    "size_m",
    type=(float, float),
    default=SIZE_M,
    show_default=True,
    help="Of the ground along x and y, without the lanes, in m.",
)
@click.option("--plugged", is_flag=True, help="Close the one way through the corridors.")
def field(**asked: object) -> None:
    """Print a random world, as a scene that every other verb can run.

    The same words print the same scene, on any machine: clew field corridors --seed 3 > maze.json
    """
    click.echo(json.dumps(scene(understand(asked, Field, "clew field"))))
