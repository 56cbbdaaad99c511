"""Figures of a campaign: success, clearance, steps, planning events, and time against loss.

Rule 1: a row is a family of scenes or, in a swarm, a class of faults. An episode counts in all its classes.
Rule 2: a share bears its lower confidence limit (Clopper and Pearson, one-sided 95 %): of n episodes without
        a failure about 1 - 3 / n, the bound of the campaign's own table.
Rule 3: an episode without a value, for example after a crash, appears only in the figure of success.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter
from scipy.special import betaincinv

from clew.campaign.episode import Outcome, Surprise
from clew.campaign.families import ALL, by_family
from clew.figures.style import BLACK, BLUE, COLUMN_IN, HAIR_PT, LOOKS, VERMILION, Chart, LeftOut, legend_below
from clew.percentiles import percentile
from clew.swarm.classes import FaultClass
from world.judge.ending import Ending

Rows = Mapping[str, Sequence[Outcome]]
Measure = Callable[[Outcome], float | None]

CONFIDENCE = 0.95
LINEAR_MM = 10.0  # the axis of margins is linear up to this, then logarithmic
ROW_IN, WORDS_IN = 0.24, 0.75
LOSS_IN = 2.6
DROP = "drop"


@dataclass(frozen=True, slots=True)
class Spread:
    """A figure of one number by row."""

    name: str
    label: str
    of: Measure
    required: float | None = None


SPREADS = (
    Spread(
        "clearance", "clearance above the required one [mm]", lambda each: _mm(each.clearance_margin_m), 0.0
    ),
    Spread("steps", "switching steps", lambda each: float(each.switching_steps)),
    Spread("events", "planning events per metre driven [1/m]", lambda each: each.events_per_m),
    Spread("time", "simulated time [s]", lambda each: each.sim_s),
)


def charts_of(outcomes: Sequence[Outcome]) -> list[Chart | LeftOut]:
    """The figures of a campaign, or the reason why there is none."""
    rows = rows_of(outcomes)
    if not rows:
        return [LeftOut("success", "no episode has been played")]
    return [_success(rows), *(_spread(spread, rows) for spread in SPREADS), _loss(outcomes)]


def rows_of(outcomes: Sequence[Outcome]) -> Rows:
    """The outcomes row by row; the last row has all of them."""
    rows: Rows = by_family(outcomes)
    if any(outcome.classes for outcome in outcomes):
        classes = {each.value: [one for one in outcomes if each in one.classes] for each in FaultClass}
        rows = {name: some for name, some in classes.items() if some}
    return {**rows, ALL: outcomes} if len(rows) > 1 else rows


def lower_limit(successes: int, episodes: int) -> float:
    """The lower limit of the true share, with 95 % confidence."""
    if successes == 0:
        return 0.0
    return float(betaincinv(successes, episodes - successes + 1, 1.0 - CONFIDENCE))


def is_safe(outcome: Outcome) -> bool:
    """Whether no promise was broken and nothing crashed."""
    return outcome.surprise not in (Surprise.VIOLATION, Surprise.CRASHED, Surprise.STOPPED)


def has_arrived(outcome: Outcome) -> bool:
    """Whether all living robots arrived."""
    return outcome.ending == Ending.ARRIVED


def loss_per_s(outcome: Outcome) -> float | None:
    """Messages that a fault plan dropped, per robot and simulated second; None: the episode did not end."""
    if not outcome.ended or outcome.robots is None or outcome.sim_s <= 0.0:
        return None
    return outcome.injected.get(DROP, 0) / outcome.robots / outcome.sim_s


def _success(rows: Rows) -> Chart:
    """The shares of episodes that kept their promises, ended as expected, and arrived."""

    def paint(figure: Figure) -> None:
        axes = _rows_axes(figure, rows)
        kinds: tuple[tuple[str, Callable[[Outcome], bool]], ...] = (
            ("no promise broken", is_safe),
            ("no surprise", lambda each: each.surprise is Surprise.NONE),
            ("all that live arrived", has_arrived),
        )
        for look, offset, (label, is_good) in zip(LOOKS, (-0.25, 0.0, 0.25), kinds, strict=False):
            good = [sum(map(is_good, some)) for some in rows.values()]
            counts = [len(some) for some in rows.values()]
            share = 100.0 * np.array(good) / np.array(counts)
            low = 100.0 * np.array([lower_limit(*each) for each in zip(good, counts, strict=True)])
            heights = np.arange(len(rows)) + offset
            axes.hlines(heights, low, share, color=look.colour, linewidth=0.8)
            axes.plot(share, heights, look.marker, color=look.colour, label=label, clip_on=False)
        axes.set(xlabel="share of episodes, and 95 % lower limit [%]", xlim=(None, 100.0))
        legend_below(figure, columns=3)

    return Chart("success", _size_in(rows), paint)


def _spread(spread: Spread, rows: Rows) -> Chart | LeftOut:
    measured = {name: _measured(spread.of, some) for name, some in rows.items()}
    if not any(len(values) for values in measured.values()):
        return LeftOut(spread.name, "no episode has this value")

    def paint(figure: Figure) -> None:
        axes = _rows_axes(figure, rows)
        for height, values in enumerate(measured.values()):
            if len(values):
                _draw_spread(axes, height, values)
        if spread.required is not None:
            axes.set_xscale("symlog", linthresh=LINEAR_MM)
            axes.xaxis.set_major_formatter(ScalarFormatter())
            axes.axvline(spread.required, color=BLACK, linestyle="--", linewidth=0.8, label="required")
        axes.set_xlabel(spread.label)
        legend_below(figure, columns=4)

    return Chart(spread.name, _size_in(rows), paint)


def _draw_spread(axes: Axes, height: float, values: Sequence[float]) -> None:
    """The range, the middle half and the median."""
    least, low, middle, high, most = (percentile(values, each) for each in (0, 25, 50, 75, 100))
    axes.plot((least, most), (height, height), "|-", color=BLUE, linewidth=HAIR_PT, label="least to most")
    axes.plot(
        (low, high), (height, height), color=BLUE, linewidth=3.0, label="middle half", solid_capstyle="butt"
    )
    axes.plot(middle, height, "o", color="white", markeredgecolor=BLACK, markeredgewidth=0.8, label="median")


def _loss(outcomes: Sequence[Outcome]) -> Chart | LeftOut:
    """The time of each episode against its message losses."""
    if not any(each.injected.get(DROP) for each in outcomes):
        return LeftOut("loss", "no message was dropped")

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        kinds = ((True, "all that live arrived", "o", BLUE), (False, "they did not", "x", VERMILION))
        for arrived, label, marker, colour in kinds:
            told = [(loss_per_s(each), each.sim_s) for each in outcomes if has_arrived(each) is arrived]
            drawn = [(loss, time_s) for loss, time_s in told if loss is not None]
            if drawn:
                axes.plot(
                    *zip(*drawn, strict=True), marker, color=colour, markerfacecolor="none", label=label
                )
        axes.set(xlabel="messages lost per robot and second [1/s]", ylabel="simulated time [s]")
        axes.set_ylim(bottom=0.0)
        legend_below(figure, columns=2)

    return Chart("loss", (COLUMN_IN, LOSS_IN), paint)


def _rows_axes(figure: Figure, rows: Rows) -> Axes:
    """One row each, from the top, with its number of episodes."""
    axes = figure.subplots()
    axes.set_yticks(range(len(rows)), [f"{name} ({len(some)})" for name, some in rows.items()])
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0.0)
    axes.grid(axis="x")
    return axes


def _size_in(rows: Rows) -> tuple[float, float]:
    return COLUMN_IN, ROW_IN * len(rows) + WORDS_IN


def _measured(of: Measure, outcomes: Sequence[Outcome]) -> list[float]:
    values = [of(outcome) for outcome in outcomes if outcome.ended]
    return [value for value in values if value is not None and math.isfinite(value)]


def _mm(length_m: float | None) -> float | None:
    return None if length_m is None else 1000.0 * length_m
