"""Options that several verbs of the command line take."""

import math
import os
import re
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar

import click
from click.shell_completion import CompletionItem

from clew.fields.kinds import ROBOT_RADIUS_M
from clew.fleet.options import DEPLOYMENTS, version
from clew.fleet.runs import EVENTS
from protocol import laws
from protocol.errors import UsageError
from protocol.files.names import did_you_mean
from protocol.files.refusals import short
from protocol.frames import ROBOTS_MAX
from protocol.law_files import is_of_file, named
from protocol.root import LAUNCH
from protocol.run_settings import SEED_MAX, SPEED_MAX
from world.scenario.sections import TIME_S_MAX

Verb = TypeVar("Verb", bound=Callable[..., Any])


class Word(click.Choice[str]):
    """One of some words. The refusal of a mistyped word names the nearest one."""

    def get_invalid_choice_message(self, value: object, ctx: click.Context | None) -> str:
        """The refusal."""
        refusal = super().get_invalid_choice_message(value, ctx).removesuffix(".")
        return refusal + (did_you_mean(str(value), self.choices) or ".")


class _OnlyFinite(click.ParamType[float]):
    """Of `nan` no comparison says that it lies outside a range."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:  # noqa: ANN401 - click's own signature
        """The number."""
        number: float = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number


class Finite(_OnlyFinite, click.types.FloatParamType):
    """A number that is neither infinite nor NaN."""


class FiniteRange(_OnlyFinite, click.FloatRange):
    """A finite number in a range."""


class NamedPath(click.Path):
    """A path, not an empty text, as of an unset shell variable: that would be the present folder."""

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> str | bytes | os.PathLike[str]:
        """The path."""
        if value == "":
            self.fail("must be a path, got an empty text", param, ctx)
        return super().convert(value, param, ctx)


class RunFolder(NamedPath):
    """The folder of a run, or its log, as verbs take it that read only the log."""

    def convert(
        self, value: str | os.PathLike[str], param: click.Parameter | None, ctx: click.Context | None
    ) -> Path:
        """The folder."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        return path.parent if path.name == EVENTS else path


class RobotNumber(click.ParamType[int]):
    """A robot, as `3` or, as the log names it, `r3`."""

    name = "robot"

    def convert(self, value: object, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """Its number."""
        match = re.fullmatch(r"r?([1-9]\d{0,8})", str(value), re.ASCII)
        if match is None:
            self.fail(f"must be a robot, as 3 or r3, got {short(value)}", param, ctx)
        return int(match[1])


class LawName(click.ParamType[str]):
    """A law of ours, of an installed package or of a file. They are looked for only when one is named."""

    name = "law"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The name, if there is such a law."""
        try:
            laws.check(name := named(value, Path()))
            if is_of_file(name):
                laws.find(name)
        except UsageError as error:
            self.fail(str(error), param, ctx)
        return value

    def shell_complete(
        self, _ctx: click.Context, _param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """The names that begin so."""
        return [CompletionItem(name) for name in laws.names() if name.startswith(incomplete)]


def _complete(folder: str) -> Callable[[click.Context, click.Parameter, str], list[CompletionItem]]:
    """Completes names of shipped files, and paths."""

    def complete(_ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        names = sorted(path.stem for path in (LAUNCH / folder).glob("*.toml"))
        found = [CompletionItem(name) for name in names if name.startswith(incomplete)]
        return found or [CompletionItem(incomplete, type="file")]

    return complete


FINITE = Finite()
PATH = NamedPath(path_type=Path)
RUN_FOLDER = RunFolder(path_type=Path)
ROBOT = RobotNumber()
ROBOTS = click.IntRange(1, ROBOTS_MAX)
SEED = click.IntRange(0, SEED_MAX)
SEEDS_MAX = 1_000_000  # a campaign keeps each in memory, and takes days for so many


def robots_option(said: str, default: int | None = None) -> Callable[[Verb], Verb]:
    """The option for a number of robots, the same in every verb."""
    return click.option(
        "-n",
        "--robots",
        "robots",
        type=ROBOTS,
        metavar="N",
        default=default,
        show_default=default is not None,
        help=said,
    )


def _seeds(_ctx: click.Context, _param: click.Parameter, said: str) -> tuple[int, ...]:
    """The seeds in a text such as 1,4-6, each once."""
    seeds: list[range] = []
    for part in said.split(","):
        match = re.fullmatch(r"(\d{1,16})(?:-(\d{1,16}))?", part, re.ASCII)
        if match is None or not int(match[1]) <= int(match[2] or match[1]) <= SEED_MAX:
            raise click.BadParameter(f"must be like 1, 1-3 or 1,4-6, up to 2**53 - 1, got {short(said)}")
        seeds.append(range(int(match[1]), int(match[2] or match[1]) + 1))
    if sum(each.stop - each.start for each in seeds) > SEEDS_MAX:
        raise click.BadParameter(f"must be at most {SEEDS_MAX:,} seeds, got {short(said)}")
    return tuple(dict.fromkeys(chain.from_iterable(seeds)))


def seeds_option(said: str, *more_names: str) -> Callable[[Verb], Verb]:
    """The option for seeds, the same in every verb."""
    return click.option(
        "--seeds", *more_names, "seeds", callback=_seeds, default="1", show_default=True, help=said
    )


def _print_version(ctx: click.Context, _param: click.Parameter, asked: bool) -> None:
    if asked:
        click.echo(version())
        ctx.exit()


VERSION = click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_print_version,
    help="Show the version and exit.",
)
ONE_SEED = click.option("--seed", type=SEED, default=1, show_default=True, help="Decides every random draw.")
OUT = click.option("--out", type=PATH, help="Folder of the run; default: a new one in runs/.")
QUIET = click.option("--quiet", is_flag=True, help="Print nothing before the run has ended.")
AS_JSON = click.option("--json", "as_json", is_flag=True, help="Print JSON, for programs.")
LAW = click.option(
    "--law",
    type=LawName(),
    help=f"Use this law instead of the scenario's: {', '.join(laws.OURS)}, "
    "an installed one, or FILE.py:NAME.",
)
DEPLOYMENT = click.option(
    "--deployment",
    type=Word(DEPLOYMENTS),
    help="Start at random free places, drawn by the seed, instead of the scenario's places.",
)
TIME = click.option(
    "--time-s-max",
    type=FiniteRange(0.0, TIME_S_MAX, min_open=True),
    help="Simulated time after which a run fails [s], instead of the scenario's.",
)
RUN = click.argument("run", type=PATH)
SCENARIO = click.argument("scenario", default="grove", shell_complete=_complete("scenarios"))
FAULTS = click.option(
    "--faults",
    metavar="PLAN",
    shell_complete=_complete("faults"),
    help="Fault plan: a name in launch/faults/, a .toml file, drawn (by the seed), or none.",
)


def speed_option(said: str, *, default: float) -> Callable[[Verb], Verb]:
    """The option for the speed of a run."""
    return click.option(
        "--speed",
        type=FiniteRange(0.0, SPEED_MAX, min_open=True),
        default=default,
        show_default=True,
        help=said,
    )


SPEED = speed_option("Speed of live fleets, times real time.", default=2.0)
COLOR = click.option(
    "--color",
    type=click.Choice(["auto", "always", "never"]),
    default="auto",
    show_default=True,
    help="When to use colours; auto: on a terminal, unless NO_COLOR is set.",
)


def robot_radius_option(said: str) -> Callable[[Verb], Verb]:
    """The option for the radius of the robots of a new scene."""
    return click.option(
        "--robot-radius",
        "robot_radius_m",
        type=FINITE,
        default=ROBOT_RADIUS_M,
        show_default=True,
        help=said,
    )


def runs_option(said: str, *, default: int) -> Callable[[Verb], Verb]:
    """The option for a number of runs."""
    return click.option(
        "--runs", type=click.IntRange(1, 10_000), default=default, show_default=True, help=said
    )


def wall_s_max(time_s_max: float, speed: float) -> float:
    """How long a live fleet may take on a busy machine: half as fast, and a minute to start and to end."""
    return 60.0 + 2.0 * time_s_max / speed
