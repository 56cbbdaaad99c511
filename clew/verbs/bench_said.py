"""How every benchmark says its result: the common JSON, or a table of its figures."""

import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from clew.verbs.say import console, say_json

if TYPE_CHECKING:
    from clew.bench.result import Figure, Machine


@dataclass(frozen=True, slots=True)
class Begun:
    """A benchmark that has begun: what is known before anything is measured."""

    benchmark: str
    about: str
    machine: "Machine"

    def say_json(self, figures: "Sequence[Figure]", details: object, packages: Sequence[str] = ()) -> None:
        """Print the result as JSON; `packages`: further packages whose versions count."""
        from clew.bench.machine import today, versions
        from clew.bench.result import Result

        result = Result(
            benchmark=self.benchmark,
            command=shlex.join(("clew", *sys.argv[1:])),
            about=self.about,
            at=today(),
            machine=self.machine,
            versions=versions(*packages),
            figures=tuple(figures),
            details=details,
        )
        say_json(result)

    def say(self, title: str, figures: "Sequence[Figure]", details: object, *, as_json: bool) -> None:
        """Print the result: as JSON, or its figures as a table."""
        self.say_json(figures, details) if as_json else print_figures(title, figures)


def begin(benchmark: str, about: str) -> Begun:
    """Note the machine and its load, before anything is measured."""
    from clew.bench.machine import machine

    return Begun(benchmark, about, machine())


def print_figures(title: str, figures: "Sequence[Figure]") -> None:
    """Print figures as a table."""
    from rich.table import Table

    from clew.bench.page import cells

    table = Table(title=title)
    for column in ("figure", "unit", "median (quartiles)", "baseline", "ratio", "aim", ""):
        table.add_column(column, justify="left" if column in ("figure", "baseline") else "right")
    for each in figures:
        for *row, met in cells(each):
            table.add_row(*row, met.replace("*", ""))
    console().print(table)
