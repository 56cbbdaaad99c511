"""`clew field`: prints a random obstacle world as a scene."""

import json

import click

from clew.fields.field import DENSITY, ROBOT_RADIUS_M, SIZE_M, WIDTH_RADII, Field, Kind, scene
from clew.verbs.options import SEED, Word
from protocol.files.reading import understand


@click.command()
@click.argument("kind", type=Word([kind.value for kind in Kind]))
@click.option("--seed", type=SEED, default=1, show_default=True, help="Decides every random draw.")
@click.option(
    "--density",
    type=float,
    default=DENSITY,
    show_default=True,
    help="Share of the ground that obstacles cover, approximately; corridors ignore it.",
)
@click.option(
    "--least-width",
    "least_width_m",
    type=float,
    help=f"Least gap between obstacles (0: they may overlap), or width of corridors [m]; "
    f"default: {WIDTH_RADII:g} robot radii.",
)
@click.option(
    "--robot-radius",
    "robot_radius_m",
    type=float,
    default=ROBOT_RADIUS_M,
    show_default=True,
    help="Radius of the robot [m]; obstacles scale with it.",
)
@click.option(
    "--size",
    "size_m",
    type=(float, float),
    default=SIZE_M,
    show_default=True,
    help="Size of the ground along x and y, without the lanes at both ends [m].",
)
@click.option(
    "--plugged", is_flag=True, help="Close the only way through the corridors, so that there is no route."
)
def field(**asked: object) -> None:
    """Print a random world as a scene, which other verbs can run.

    The same options print the same scene on any machine. Example: clew field corridors --seed 3 > maze.json
    """
    click.echo(json.dumps(scene(understand(asked, Field, "clew field"))))
