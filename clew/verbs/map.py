"""`clew map`: makes a scene from a ROS map."""

import json
import math
from itertools import takewhile
from pathlib import Path
from typing import Any

import click

from clew.verbs.extras import need
from clew.verbs.options import FINITE, PATH, robot_radius_option
from clew.verbs.say import warn
from protocol.errors import UsageError
from protocol.files.opening import WRITTEN_BYTES_MAX
from protocol.files.reading import understand


class _WithPlaces(click.Command):
    """Names the option that has too few numbers; click would take the next option for one of them."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        several = {name: option for option in self.params if option.nargs > 1 for name in option.opts}
        for at, word in enumerate(args):
            if option := several.get(word):
                given = list(takewhile(lambda said: not said.startswith("--"), args[at + 1 :]))[
                    : option.nargs
                ]
                if len(given) < option.nargs:
                    wanted = f"{word} needs {option.nargs} numbers, {option.metavar}"
                    raise click.BadOptionUsage(word, f"{wanted}, got {' '.join(given) or 'none'}", ctx)
        return super().parse_args(ctx, args)


def _heading(
    ctx: click.Context, param: click.Parameter, start: tuple[float, float, float]
) -> tuple[float, float, float]:
    """The start, unless its heading seems to be in degrees."""
    if abs(start[2]) > 2 * math.pi:
        said = f"HEADING must be in radians, from -2 pi to 2 pi, got {start[2]:g}"
        raise click.BadParameter(said, ctx, param)
    return start


@click.command("map", cls=_WithPlaces)
@click.argument("file", metavar="FILE.yaml", type=PATH)
@click.option(
    "--start",
    type=(FINITE, FINITE, FINITE),
    required=True,
    callback=_heading,
    metavar="X Y HEADING",
    help="Where the first robot starts [m, m, rad], in the map's frame; the others queue behind it.",
)
@click.option(
    "--goal",
    "goal_m",
    type=(FINITE, FINITE),
    required=True,
    metavar="X Y",
    help="Where the leader has to go [m].",
)
@robot_radius_option("Radius of each robot [m].")
@click.option(
    "--coarsen",
    type=click.IntRange(1, 1000),
    default=1,
    metavar="K",
    help="Join K x K cells into one, an obstacle if any of them is: fewer corners, and obstacles that are "
    "larger by less than K cells.",
)
def map_verb(file: Path, *, robot_radius_m: float, **asked: Any) -> None:  # noqa: ANN401 - handed on
    """Print a ROS map as a scene, which other verbs can run.

    FILE.yaml is a map as map_server reads it, with its image (PGM, PNG or BMP) beside it. Every cell that is
    not known to be free is an obstacle: also unknown cells, and everything beyond the image.
    """
    if not file.exists():  # first: a mistyped path needs no library
        raise UsageError(f"{file}: there is no such file")
    for module in ("PIL", "yaml"):
        need(module, extra="maps", by="maps need")
    from clew.maps.occupancy import SAVED_UNKNOWN, read_map
    from clew.maps.scene import scene
    from world.scenario.scene import ROBOTS

    ground = read_map(file)
    if ground.doubtful:
        warn(
            f"{file}: {ground.doubtful} cells are free by its free_thresh, and have grey {SAVED_UNKNOWN}, "
            "by which map_saver writes unknown cells; with free_thresh: 0.196 they are obstacles"
        )
    try:
        made = scene(ground, file.stem, robot_radius_m=robot_radius_m, **asked)
    except UsageError as error:
        raise UsageError(f"{file}: {error}") from error
    said = json.dumps(made)
    if len(said) > WRITTEN_BYTES_MAX:
        raise UsageError(f"{file}: the scene would be longer than {WRITTEN_BYTES_MAX} bytes; try --coarsen 2")
    polygons, (x_m_min, y_m_min, x_m_max, y_m_max) = made["polygons"], made["bounds"]
    warn(
        f"{file}: {len(polygons)} obstacles with {sum(map(len, polygons))} corners; "
        f"free ground from ({x_m_min:g}, {y_m_min:g}) to ({x_m_max:g}, {y_m_max:g}) m"
    )  # before what is refused: it shows a wrong resolution or origin, and where places can be
    try:
        _check(json.loads(said), str(file), robots=ROBOTS)
    except UsageError as error:
        _check(json.loads(said), str(file), robots=1)
        warn(f"no room for a queue of {ROBOTS}: {error}")
    click.echo(said)


def _check(made: dict[str, Any], source: str, *, robots: int) -> None:
    """Refuse a scene that does not work for so many robots."""
    from world.scenario.scenario import Scenario
    from world.scenario.scene import as_scenario, in_own_words

    raw = as_scenario(made, source)
    raw["fleet"]["robots"] = robots
    try:
        understand(raw, Scenario, source)
    except UsageError as error:
        raise UsageError(in_own_words(str(error), made)) from error
