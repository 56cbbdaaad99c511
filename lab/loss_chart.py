"""The figure of `docs/faults.md`: time to the goal against loss. It wants matplotlib, the extra `plot`."""

import math
from collections.abc import Sequence
from io import StringIO

from lab.bench_loss import LossPoint, Reach, median_s, worst_s
from protocol.errors import UsageError

NAMES = {Reach.LINKS: "what robots say to each other", Reach.ALL: "every message"}
COLOURS = {Reach.LINKS: "#1f6f8b", Reach.ALL: "#b5541c"}  # far apart for the colour-blind, too
NEVER_AT = {Reach.LINKS: 0.96, Reach.ALL: 0.9}  # of the height: where both have one, one above the other
SIZE_IN = (6.4, 3.6)
CSS = {
    "svg.hashsalt": "clew",
    "svg.fonttype": "none",
}  # the same bytes each time, and text that can be searched


def chart(points: Sequence[LossPoint], title: str) -> str:
    """The figure as SVG: medians as lines, the worst as bands, live runs as crosses, never as triangles.

    Raises:
        UsageError: matplotlib is not there.
    """
    try:
        import matplotlib as mpl  # noqa: PLC0415 - nobody else is to wait a second for it
        from matplotlib.figure import Figure  # noqa: PLC0415 - for the same reason
    except ImportError as error:
        raise UsageError("the figure needs matplotlib: pip install '.[plot]'") from error
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    axes = figure.subplots()
    for reach in Reach:
        own = sorted((point for point in points if point.reach is reach), key=lambda point: point.rate)
        rates = [100.0 * point.rate for point in own]
        middle_s = [_drawn_s(median_s(point.rehearsed)) for point in own]
        longest_s = [_drawn_s(worst_s(point.rehearsed)) for point in own]
        axes.fill_between(rates, middle_s, longest_s, color=COLOURS[reach], alpha=0.18, linewidth=0.0)
        axes.plot(rates, middle_s, "o-", color=COLOURS[reach], label=f"{NAMES[reach]}, rehearsed")
        live = [(100.0 * point.rate, _drawn_s(run.time_s)) for point in own for run in point.live]
        if live:
            axes.plot(*zip(*live, strict=True), "x", color=COLOURS[reach], label=f"{NAMES[reach]}, live")
        never = [100.0 * point.rate for point in own if math.isinf(median_s(point.rehearsed))]
        edge = axes.get_xaxis_transform()
        axes.plot(never, [NEVER_AT[reach]] * len(never), "^", color=COLOURS[reach], transform=edge)
    axes.set_xticks(sorted({100.0 * point.rate for point in points}))
    axes.set(xlabel="lost [%]", ylabel="time until all have arrived [s]", title=title, ylim=(0.0, None))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    # The same bytes each time, and text that can be searched.
    with mpl.rc_context({"svg.hashsalt": "clew", "svg.fonttype": "none"}), StringIO() as file:
        figure.savefig(file, format="svg", metadata={"Date": None})
        return "\n".join(line.rstrip() for line in file.getvalue().splitlines()) + "\n"


def _drawn_s(time_s: float | None) -> float:
    """A time as it is drawn: one that never came is a hole."""
    return time_s if time_s is not None and math.isfinite(time_s) else math.nan
