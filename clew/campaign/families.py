"""The figures of a campaign by family, and the printed table.

Rule 1: every episode counts as exactly one of `ARRIVALS`, in the table as in the last line.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from msgspec import Struct
from rich.table import Table
from rich.text import Text

from clew.campaign.episode import CRASHED, OUT_OF_TIME, Outcome, Surprise
from clew.percentiles import percentile
from protocol.plain import plain

ALL = "all"
ARRIVALS = {
    "arrived": "arrived",
    "no_way": "found no way",
    "not_asked": "did not have to",
    "failed": "failed",
}
"""What became of the fleets, by field of `Figures`."""


class Figures(Struct, frozen=True, kw_only=True):
    """The figures of all episodes of a family; docs/campaign.md explains each field."""

    episodes: int
    arrived: int
    no_way: int
    not_asked: int
    failed: int
    solvable: int | None
    """None: no scene says whether there is a way."""
    no_route: int
    surprises: int
    crashed: int
    stopped: int
    fewer_robots: int
    violations: int
    switching_steps_median: float | None
    switching_steps_max: int | None
    clearance_margin_m_min: float | None
    events_per_m: float | None
    wall_s: float


def figures_of(outcomes: Sequence[Outcome]) -> Figures:
    """The figures of these outcomes."""
    steps = [outcome.switching_steps for outcome in outcomes if outcome.ended]
    margins = [each.clearance_margin_m for each in outcomes if each.clearance_margin_m is not None]
    path_m = sum(outcome.path_m for outcome in outcomes)
    known = [outcome.solvable for outcome in outcomes if outcome.solvable is not None]
    arrivals = Counter(map(_arrival, outcomes))
    return Figures(
        episodes=len(outcomes),
        **{field: arrivals[field] for field in ARRIVALS},
        solvable=sum(known) if known else None,
        no_route=sum(outcome.no_route for outcome in outcomes),
        surprises=sum(outcome.surprise is not Surprise.NONE for outcome in outcomes),
        crashed=sum(outcome.ending == CRASHED for outcome in outcomes),
        stopped=sum(outcome.ending == OUT_OF_TIME for outcome in outcomes),
        fewer_robots=sum(outcome.robots_left_out > 0 for outcome in outcomes),
        violations=sum(outcome.violations for outcome in outcomes),
        switching_steps_median=percentile(steps, 50) if steps else None,
        switching_steps_max=max(steps, default=None),
        clearance_margin_m_min=min(margins, default=None),
        events_per_m=sum(each.planning_events for each in outcomes) / path_m if path_m > 0.0 else None,
        wall_s=sum(outcome.wall_s for outcome in outcomes),
    )


def in_words(outcomes: Sequence[Outcome]) -> str:
    """Whether promises were kept, and which fleets arrived."""
    broken = sum(outcome.violations > 0 for outcome in outcomes)
    runs = f"{len(outcomes)} {'run' if len(outcomes) == 1 else 'runs'}"
    promises = f"promises broken in {broken} of {runs}" if broken else f"no promise broken in {runs}"
    counts = Counter(map(_arrival, outcomes))
    arrivals = (f"{counts[field]} {said}" for field, said in ARRIVALS.items() if counts[field])
    return "; ".join(filter(None, (promises, ", ".join(arrivals))))


def _arrival(outcome: Outcome) -> str:
    """Which of `ARRIVALS` it is."""
    if outcome.ok:
        return "arrived"
    if outcome.surprise is not Surprise.NONE:
        return "failed"
    # In a safety episode of a swarm faults last to the end; in the others dead bodies may bar the way.
    return "no_way" if outcome.no_route else "failed" if outcome.mode is None else "not_asked"


def by_family(outcomes: Iterable[Outcome]) -> dict[str, list[Outcome]]:
    """The outcomes by family."""
    families: dict[str, list[Outcome]] = {}
    for outcome in outcomes:
        families.setdefault(outcome.family, []).append(outcome)
    return dict(sorted(families.items()))


def table(families: Mapping[str, Figures], whole: Figures) -> Table:
    """A row for each family, then a row for all."""
    columns = ("family", *(title for title, _ in _cells(whole)))
    drawn = Table(*columns)
    for column in drawn.columns[1:]:
        column.justify = "right"
    for name, figures in families.items():
        drawn.add_row(Text(plain(name)), *(cell for _, cell in _cells(figures)))
    drawn.add_section()
    drawn.add_row(ALL, *(cell for _, cell in _cells(whole)))
    return drawn


def _cells(figures: Figures) -> Iterator[tuple[str, str]]:
    yield "runs", str(figures.episodes)
    yield "arrived", str(figures.arrived)
    yield "no way", str(figures.no_way)
    yield "not\nasked", str(figures.not_asked)
    yield "failed", str(figures.failed)
    yield "solvable", _formatted(figures.solvable, "d")
    yield "surprises", str(figures.surprises)
    yield "violations", str(figures.violations)
    yield "steps", _formatted(figures.switching_steps_median, "g")
    yield "max", _formatted(figures.switching_steps_max, "d")
    yield "margin\nmm", _formatted(_mm(figures.clearance_margin_m_min), "+.2f")
    yield "events\n/m", _formatted(figures.events_per_m, ".3f")
    yield "fewer", str(figures.fewer_robots)
    yield "wall\ns", f"{figures.wall_s:.0f}"


def _formatted(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def _mm(length_m: float | None) -> float | None:
    return None if length_m is None else 1000.0 * length_m
