"""`clew field`: prints a random scene, or writes many."""

import json
from itertools import product
from pathlib import Path

import click

from clew.fields.kinds import DENSITY, SIZE_M, WIDTH_RADII, Kind
from clew.verbs.options import FINITE, PATH, Word, robot_radius_option, seeds_option
from protocol.errors import UsageError
from protocol.files.reading import understand
from protocol.files.writing import check_ours, make_folder, write_whole


@click.command()
@click.argument("kinds", metavar="KIND...", nargs=-1, required=True, type=Word([kind.value for kind in Kind]))
@seeds_option("Decides every random draw; with --out several, as 1-3 or 1,4-6.", "--seed")
@click.option(
    "--density",
    type=FINITE,
    default=DENSITY,
    show_default=True,
    help="Share of the ground that obstacles cover, approximately; built ground ignores it.",
)
@click.option(
    "--least-width",
    "least_width_m",
    type=FINITE,
    help=f"Least gap between obstacles (0: they may overlap), or width of built ways [m]; "
    f"default: {WIDTH_RADII:g} robot radii.",
)
@click.option(
    "--spare",
    type=FINITE,
    help="Instead of --least-width: how much wider than 2 (r + epsilon), as a share.",
)
@robot_radius_option("Radius of the robot [m]; obstacles scale with it.")
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
@click.option(
    "--out",
    type=PATH,
    help="Folder to write scenes to, one folder a kind, as a campaign takes them.",
)
def field(kinds: tuple[str, ...], *, seeds: tuple[int, ...], out: Path | None, **asked: object) -> None:
    """Print a random scene, which other verbs can run, or write many scenes with --out.

    Circles, ellipses, convex, nonconvex, mixed and stars are scattered. Corridors (a perfect maze), zigzag,
    comb, spiral, rings, rooms and pillars are built with ways of one width.

    The same options print the same scene on any machine.
    """
    from clew.fields.field import Field, mark, scene

    drawn = (
        (kind, seed, scene(understand({**asked, "kind": kind, "seed": seed}, Field, "clew field")))
        for kind, seed in product(kinds, seeds)
    )
    if out is None:
        if len(kinds) * len(seeds) > 1:
            raise UsageError("clew field: one kind and one seed are printed; for several, give --out")
        click.echo(json.dumps(next(drawn)[2]))
        return
    for kind, seed in product(kinds, seeds):
        check_ours(_place(out, kind, seed), mark(kind, seed))
    try:
        for kind, seed, world in drawn:
            make_folder(out / kind)
            write_whole(_place(out, kind, seed), json.dumps(world).encode() + b"\n")
    except OSError as error:
        raise UsageError(f"cannot write {error.filename or out}: {error.strerror or error}") from error
    click.echo(str(out))


def _place(out: Path, kind: str, seed: int) -> Path:
    return out / kind / f"{kind}-{seed}.json"
