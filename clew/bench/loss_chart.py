"""The figure of `docs/measured.md`: time to the goal against message loss."""

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from clew.bench.loss import NAMES, LossPoint, Reach, median_s, worst_s
from clew.figures.style import BLUE, PAGE_IN, VERMILION, Chart, Look

LOOKS = {Reach.LINKS: Look(BLUE, "o", (0, ())), Reach.ALL: Look(VERMILION, "s", (0, (5.0, 1.5)))}
NEVER_AT = {Reach.LINKS: 0.96, Reach.ALL: 0.9}  # share of the height, so that two marks do not overlap
HEIGHT_IN = 3.2


def loss_chart(points: Sequence[LossPoint], title: str) -> Chart:
    """Medians as lines, the range up to the worst as bands, live runs as crosses, *never* as triangles."""

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for reach in Reach:
            own = sorted((point for point in points if point.reach is reach), key=lambda point: point.rate)
            _draw(axes, reach, own)
        axes.set_xticks(sorted({100.0 * point.rate for point in points}))
        axes.set(xlabel="lost [%]", ylabel="time until all have arrived [s]", title=title, ylim=(0.0, None))
        axes.grid()
        axes.legend()

    return Chart("loss", (PAGE_IN, HEIGHT_IN), paint)


def _draw(axes: Axes, reach: Reach, own: Sequence[LossPoint]) -> None:
    """Draw the runs of one reach."""
    look = LOOKS[reach]
    rates = [100.0 * point.rate for point in own]
    middle_s = [_drawn_s(median_s(point.rehearsed)) for point in own]
    longest_s = [_drawn_s(worst_s(point.rehearsed)) for point in own]
    axes.fill_between(rates, middle_s, longest_s, color=look.colour, alpha=0.18, linewidth=0.0)
    rehearsed = f"{NAMES[reach]}, rehearsed"
    axes.plot(rates, middle_s, look.marker, color=look.colour, linestyle=look.dashes, label=rehearsed)
    live = [(100.0 * point.rate, _drawn_s(run.time_s)) for point in own for run in point.live]
    if live:
        axes.plot(*zip(*live, strict=True), "x", color=look.colour, label=f"{NAMES[reach]}, live")
    never = [100.0 * point.rate for point in own if math.isinf(median_s(point.rehearsed))]
    edge = axes.get_xaxis_transform()
    axes.plot(never, [NEVER_AT[reach]] * len(never), "^", color=look.colour, transform=edge)


def _drawn_s(time_s: float | None) -> float:
    """The time to draw; NaN, a hole in the line, where the fleet did not arrive."""
    return time_s if time_s is not None and math.isfinite(time_s) else math.nan
