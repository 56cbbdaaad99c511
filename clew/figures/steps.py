"""Each switching step in a panel: the leader's scan, the chosen gap and the target [m; world frame]."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from clew.figures.ground import OVER, Frame, draw_ground, frame_of
from clew.figures.region import chosen_gap_m, draw_robots
from clew.figures.style import BLACK, BLUE, COLUMN_IN, HAIR_PT, PAGE_IN, Chart, LeftOut, legend_below
from clew.story.course import Course
from clew.story.steps import Step

PANELS_MAX = 12
TITLE_IN, LEGEND_IN, SCALE_IN, PAD_IN = 0.18, 0.25, 0.22, 0.03
SCALE_PT = 5.0  # the numbers of the axes
MARGIN = 0.02  # of the longer side: panels are close together
TALL, WIDE = 1.5, 0.4  # ratios of height to width: above, more panels in a row; below, fewer
HEAD_PT = 5.0  # of the arrow: as long as the shortest steps
SEEN: dict[str, Any] = {"color": BLACK, "marker": ".", "markersize": 2.0, "linewidth": HAIR_PT}
CHOSEN: dict[str, Any] = {"color": BLACK, "linestyle": "--", "linewidth": 1.2}
STEP: dict[str, Any] = {"color": BLUE, "linewidth": 0.8}


def steps(course: Course) -> Chart | LeftOut:
    """The switching steps of a run; if there are many, an even selection."""
    if not course.steps:
        return LeftOut("steps", "the leader has not planned a switching step")
    frame = frame_of(course, MARGIN)
    shown = evenly(course.steps, PANELS_MAX)
    columns = min(len(shown), 6 if frame.aspect > TALL else 2 if frame.aspect < WIDE else 3)
    width_in = COLUMN_IN if columns == 1 else PAGE_IN
    rows = math.ceil(len(shown) / columns)
    height_in = rows * (width_in / columns * frame.aspect + TITLE_IN) + LEGEND_IN + SCALE_IN

    def paint(figure: Figure) -> None:
        figure.set_layout_engine("constrained", w_pad=PAD_IN, h_pad=PAD_IN, wspace=0.0, hspace=0.0)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes in panels[len(shown) :]:
            axes.set_axis_off()
        for place, (axes, step) in enumerate(zip(panels, shown, strict=False)):
            _draw(axes, course, frame, step)
            said = f"step {step.number}, robot {step.robot}, {step.t_s:.1f} s"
            axes.set_title(said, fontsize=6.0, pad=2.0)
            _draw_axes(axes, is_left=place % columns == 0, is_low=place + columns >= len(shown))
        legend_below(figure, columns=5, handles=_legend(course, len(shown)))

    return Chart("steps", (width_in, height_in), paint)


def evenly(all_steps: Sequence[Step], most: int) -> list[Step]:
    """The first, the last, and an even selection between them."""
    rows = np.unique(np.linspace(0, len(all_steps) - 1, min(most, len(all_steps))).round().astype(int))
    return [all_steps[row] for row in rows.tolist()]


def _draw(axes: Axes, course: Course, frame: Frame, step: Step) -> None:
    plan = step.plan
    draw_ground(axes, course, frame, t_s=step.t_s)
    for seen in plan.obstacles:
        one, other = seen.tangent_1, seen.tangent_2
        axes.plot((one.x_m, other.x_m), (one.y_m, other.y_m), **SEEN)
    ends_m = chosen_gap_m(step)
    if ends_m is not None:
        axes.plot(*ends_m.T, **CHOSEN)
    if len(course.times_s):
        draw_robots(axes, course, course.places_at_m(step.t_s), step.robot, size_pt=1.8)
    axes.annotate(
        "",
        (plan.target.x_m, plan.target.y_m),
        (plan.x_m, plan.y_m),
        arrowprops={"arrowstyle": "->", "shrinkA": 0.0, "shrinkB": 0.0, "mutation_scale": HEAD_PT, **STEP},
        zorder=OVER + 0.5,
    )


def _draw_axes(axes: Axes, *, is_left: bool, is_low: bool) -> None:
    """Axes with their scale in every panel; numbers only at the left and below the lowest."""
    axes.tick_params(labelsize=SCALE_PT, length=1.5, pad=1.0, labelleft=is_left, labelbottom=is_low)
    axes.locator_params(nbins=4)
    if is_left:
        axes.set_ylabel("y [m]", fontsize=SCALE_PT, labelpad=1.0)
    if is_low:
        axes.set_xlabel("x [m]", fontsize=SCALE_PT, labelpad=1.0)


def _legend(course: Course, shown: int) -> list[Artist]:
    count = len(course.steps)
    said = "switching step" if shown == count else f"switching step ({shown} of {count} drawn)"
    handles: list[Artist] = [Line2D([], [], label="tangent points and chord", **SEEN)]
    if any(chosen_gap_m(each) is not None for each in course.steps):
        handles.append(Line2D([], [], label="gap chosen", **CHOSEN))
    return [*handles, Line2D([], [], label=said, **STEP)]
