"""The style of all figures, and their conversion to bytes.

Rule 1: the same figure has the same bytes: without dates, with salted ids, without the user's matplotlibrc.
Rule 2: every meaning of a colour is also shown by a marker or a line style.
Rule 3: text stays text, so that it can be searched and edited.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

COLUMN_IN, PAGE_IN = 3.5, 7.16  # widths of one and of both columns in IEEE's journals
PNG_DPI = 300.0  # the minimum of most journals
HAIR_PT, LINE_PT = 0.5, 1.0
BLACK, GREY, PALE = "#000000", "#7f7f7f", "#d9d9d9"

# Okabe and Ito's palette, which colour-blind people can distinguish; without its yellow, too pale on paper.
BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY = (
    "#0072B2",
    "#D55E00",
    "#009E73",
    "#CC79A7",
    "#E69F00",
    "#56B4E9",
)

RC: Any = {  # its type in matplotlib lists every existing parameter
    "axes.axisbelow": True,
    "axes.linewidth": HAIR_PT,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 7.0,  # the size of captions in most journals, at column width
    "grid.alpha": 0.3,
    "grid.linewidth": HAIR_PT,
    "legend.fontsize": 6.0,
    "legend.frameon": False,
    "legend.handlelength": 2.2,
    "lines.linewidth": LINE_PT,
    "lines.markersize": 3.0,
    "pdf.fonttype": 42,  # TrueType, whole outlines: many journals refuse type 3
    "svg.fonttype": "none",
    "svg.hashsalt": "clew",
    "xtick.major.width": HAIR_PT,
    "ytick.major.width": HAIR_PT,
}
MARK = "clew figures"  # in every file of ours
METADATA: dict[str, dict[str, Any]] = {
    "svg": {"Date": None, "Creator": MARK},
    "pdf": {"CreationDate": None, "Creator": MARK},
    "png": {"Software": MARK},
}


@dataclass(frozen=True, slots=True)
class Look:
    """The look that distinguishes one of several lines."""

    colour: str
    marker: str
    dashes: tuple[int, tuple[float, ...]]
    width_pt: float = LINE_PT


LOOKS = (
    Look(BLUE, "o", (0, ())),
    Look(VERMILION, "s", (0, (5.0, 1.5))),
    Look(GREEN, "^", (0, (2.0, 1.2))),
    Look(PURPLE, "D", (0, (6.0, 1.5, 1.0, 1.5))),
    Look(ORANGE, "v", (0, (1.0, 1.0))),
    Look(SKY, "P", (0, (8.0, 2.0))),
)


@dataclass(frozen=True, slots=True)
class Chart:
    """A figure that can be drawn: the name of its files, its size, and its drawing function."""

    name: str
    size_in: tuple[float, float]
    paint: Callable[[Figure], None]


@dataclass(frozen=True, slots=True)
class LeftOut:
    """A figure that cannot be drawn, and the reason."""

    name: str
    why: str


def render(chart: Chart, formats: Iterable[str]) -> dict[str, bytes]:
    """The bytes of a figure in each of these formats."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(RC)
        figure = Figure(figsize=chart.size_in, layout="constrained")
        chart.paint(figure)
        return {form: _saved(figure, form) for form in formats}


def limit(axes: Axes, height: float, said: str, *, dashes: str = "--") -> None:
    """A horizontal line with its legend entry."""
    axes.axhline(height, color=BLACK, linestyle=dashes, linewidth=0.8, label=said, zorder=1.5)


def legend_below(figure: Figure, *, columns: int, handles: Iterable[Artist] = ()) -> None:
    """A legend below all panels, with these handles or with one entry per label."""
    entries: dict[object, Artist] = {handle.get_label(): handle for handle in handles}
    for axes in () if entries else figure.axes:
        drawn, labels = axes.get_legend_handles_labels()
        entries = {**dict(zip(labels, drawn, strict=True)), **entries}
    figure.legend(
        handles=list(entries.values()),
        labels=list(map(str, entries)),
        loc="outside lower center",
        ncols=columns,
    )


def _saved(figure: Figure, form: str) -> bytes:
    with BytesIO() as file:
        figure.savefig(file, format=form, dpi=PNG_DPI, metadata=METADATA[form])
        return file.getvalue()
