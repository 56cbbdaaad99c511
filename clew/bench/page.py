"""The results of benchmarks as a page of the docs, in Markdown: the missed aims first. Pure."""

from collections.abc import Sequence

from msgspec.structs import replace

from clew.bench.result import Aim, Figure, Result, Spread

MARK = "`clew bench page` writes this page"
HEAD = f"""# Performance

What Clew costs, beside peers and the bare transport in the same run. {MARK} from
the files in [docs/performance](performance), which `clew bench ... --json` made. Do not edit it by hand.

A figure is the median of its repeats, with the first and third quartile in brackets. A ratio is the figure
divided by its baseline, repeat by repeat. A figure is true of its commit and its machine only.
"""
TIMES = ("s", "ms", "us", "simulated s")
ROWS = ("| figure | unit | measured | baseline | ratio | aim | |", "|---|---|---|---|---|---|---|")


def page(results: Sequence[Result]) -> str:
    """The whole page."""
    return "\n".join([HEAD, *_misses(results), *(line for each in results for line in _section(each))])


def said(spread: Spread, unit: str) -> str:
    """A spread in words: median, and quartiles of several repeats; the unit says what none means."""
    median, *quartiles = (
        said_number(value, unit) for value in (spread.median, spread.quartile, spread.quartile_3)
    )
    return median if spread.repeats == 1 else f"{median} ({' to '.join(quartiles)})"


def said_number(value: float | None, unit: str) -> str:
    """A number with three digits that count. A time that is none never came; all else was not measured."""
    if value is None:
        return "never" if unit in TIMES else "not measured"
    return f"{value:,.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def said_aim(aim: Aim | None) -> str:
    """What is to be reached."""
    if aim is None:
        return ""
    bounds = [
        f"at {word} {bound:g}"
        for word, bound in (("most", aim.at_most), ("least", aim.at_least))
        if bound is not None
    ]
    said_bounds = " and ".join(bounds) or "to come"
    return f"{'each ' if aim.each else ''}{said_bounds}{f' of {aim.of}' if aim.of else ''}"


def said_met(figure: Figure) -> str:
    """Whether the aim is reached."""
    return {None: "", True: "met", False: "**missed**"}[figure.met]


def _misses(results: Sequence[Result]) -> list[str]:
    missed = [(result, each) for result in results for each in result.figures if each.met is False]
    asked = sum(each.met is not None for result in results for each in result.figures)
    lines = ["## Missed aims", "", f"{len(missed)} of {asked} aims are missed.", ""]
    if missed:
        rows = [
            f"| `{result.benchmark}` | {each.name} | {_reached(each)} | {said_aim(each.aim)} |"
            for result, each in missed
        ]
        lines += ["| benchmark | figure | reached | aim |", "|---|---|---|---|", *rows, ""]
    return lines


def _reached(figure: Figure) -> str:
    """What the aim is compared with."""
    ratios = {each.name: said(each.ratio, figure.unit) for each in figure.baselines}
    aimed = figure.aim.of if figure.aim is not None else ""
    measured = figure.measured
    if figure.aim is not None and figure.aim.each:
        measured = replace(measured, repeats=1, median=measured.most)
    unit = "" if measured.median is None else figure.unit
    return ratios.get(aimed, f"{said(measured, figure.unit)} {unit}".rstrip())


def _section(result: Result) -> list[str]:
    machine = result.machine
    versions = ", ".join(f"{name} {version}" for name, version in result.versions.items())
    repeats = sorted({each.measured.repeats for each in result.figures})
    return [
        f"## `clew bench {result.benchmark}`",
        "",
        f"{result.about}",
        "",
        f"`{result.command}`, {result.at}; repeats: {', '.join(map(str, repeats))}.",
        f"{machine.cpu}, {machine.cores} cores, {machine.memory_mb / 1000.0:.0f} GB, Linux {machine.kernel}; "
        f"load {machine.load:g} at the start.",
        f"{versions}.",
        "",
        *ROWS,
        *(_row(row) for each in result.figures for row in cells(each)),
        "",
    ]


def _row(row: Sequence[str]) -> str:
    return f"| {' | '.join(row)} |".replace("|  |", "| |").replace("|  |", "| |")


def cells(figure: Figure) -> list[tuple[str, ...]]:
    """The cells of a row for the figure, and of one more for each further baseline."""
    unit = figure.unit
    named = [
        (f"{each.name}: {said(each.measured, unit)}", said(each.ratio, unit)) for each in figure.baselines
    ]
    compared = named or [("", "")]
    aim = (said_aim(figure.aim), said_met(figure))
    return [
        (figure.name, unit, said(figure.measured, unit), *compared[0], *aim),
        *(("", "", "", *more, "", "") for more in compared[1:]),
    ]
