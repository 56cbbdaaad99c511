"""The paper's Figure 4: the leader's distance to each obstacle at each switching position [m]."""

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from clew.figures.style import BLACK, COLUMN_IN, GREY, LOOKS, Chart, LeftOut, legend_below, limit
from clew.story.course import Course
from clew.story.steps import Ending
from protocol.arrays import Floats
from world.geometry.clearance import distances as apart_m
from world.judge.table import measure

NAME = "distances"
SIZE_IN = (COLUMN_IN, 2.6)
POSITIONS_TOLD = 12  # as many numbers as fit below the axis
PRINTED: dict[str, Any] = {
    "linestyle": "",
    "markerfacecolor": "none",
    "markersize": 6.0,
    "markeredgewidth": 0.7,
}
TOLD_APART = len(LOOKS)  # obstacles with separate lines: those nearest to the leader


def distances(course: Course) -> Chart | LeftOut:
    """Figure 4 of a run."""
    if not course.stands:
        return LeftOut(NAME, "the leader has not begun a switching step")
    if not course.scenario.seen_shapes:
        return LeftOut(NAME, "there is no obstacle")
    return Chart(NAME, SIZE_IN, lambda figure: _paint(figure, course))


def from_hull_m(course: Course) -> Floats:
    """From the leader's hull: a row for each switching position, a column for each obstacle, as in Table I.

    Moving obstacles come last, at their places when the leader arrived.
    """
    scenario = course.scenario
    ground, movers = scenario.ground, scenario.movers
    rows = measure(scenario, [stand.place for stand in course.stands])
    moved = [
        apart_m(movers.among(ground, stand.t_s), np.array([stand.place.x_m, stand.place.y_m]))
        for stand in course.stands
    ]
    from_centre_m = np.hstack((np.array(rows), np.array(moved)[:, ground.shape_count :]))
    return from_centre_m - scenario.fleet.robot_radius_m


def named_obstacles(course: Course) -> list[int]:
    """The columns of the obstacles nearest to the leader at its switching positions."""
    if not course.stands:
        return []
    nearest = np.argsort(from_hull_m(course).min(axis=0), kind="stable")
    return sorted(nearest[:TOLD_APART].tolist())


def _paint(figure: Figure, course: Course) -> None:
    axes = figure.subplots()
    hull_m = from_hull_m(course)
    positions = np.arange(1, len(hull_m) + 1)
    nearest = named_obstacles(course)
    others = np.setdiff1d(np.arange(hull_m.shape[1]), nearest)
    names = [
        *(f"obstacle {index}" for index, _ in enumerate(course.scenario.obstacles, start=1)),
        *course.scenario.movers.names,
    ]
    for look, obstacle in zip(LOOKS, nearest, strict=False):
        axes.plot(
            positions,
            hull_m[:, obstacle],
            color=look.colour,
            marker=look.marker,
            linestyle=look.dashes,
            label=names[obstacle],
        )
    for index, obstacle in enumerate(others.tolist()):
        label = f"{len(others)} others" if index == 0 else None
        axes.plot(positions, hull_m[:, obstacle], color=GREY, alpha=0.4, linewidth=0.4, label=label)
    _draw_paper(axes, course, nearest)
    draw_limits(axes, course)
    axes.set(xlabel="switching position", ylabel="leader's distance [m]")
    axes.set_ylim(0.0, 1.05 * float(hull_m[:, nearest].max()))
    told = positions[:: math.ceil(len(positions) / POSITIONS_TOLD)]
    axes.set_xticks(told, [course.stands[position - 1].name for position in told])
    axes.margins(x=0.03)
    legend_below(figure, columns=3)


def _draw_paper(axes: Axes, course: Course, obstacles: list[int]) -> None:
    """Draw the values of the paper's Table I, where the scenario has them, as hollow markers."""
    table_m = course.scenario.table_m
    rows = list(_rows_of_table(course, 0 if table_m is None else len(table_m)))
    if table_m is None or not rows:
        return
    positions, printed_m = [position for position, _ in rows], np.array([table_m[row] for _, row in rows])
    hull_m = printed_m - course.scenario.fleet.robot_radius_m
    for look, obstacle in zip(LOOKS, obstacles, strict=False):
        if obstacle < hull_m.shape[1]:
            axes.plot(positions, hull_m[:, obstacle], color=look.colour, marker=look.marker, **PRINTED)
    axes.plot([], [], color=BLACK, marker="o", label="paper's Table I", **PRINTED)


def _rows_of_table(course: Course, count: int) -> Iterator[tuple[int, int]]:
    """The positions of the figure, from 1, that Table I has: the start, and the ends of finished steps."""
    ends = [step.end.at for step in course.steps if step.end is not None and step.end.how is Ending.FINISHED]
    row = 0
    for position, stand in enumerate(course.stands, start=1):
        if row == count:
            return
        if row == 0 or (row <= len(ends) and stand.place == ends[row - 1]):
            yield position, row
            row += 1


def draw_limits(axes: Axes, course: Course) -> None:
    """Draw the required clearance, and what remains of it after the tolerance."""
    law = course.scenario.law
    limit(axes, law.epsilon_m, r"$\varepsilon$")
    limit(axes, law.epsilon_m - law.mu0_m, r"$\varepsilon - \mu_0$", dashes=":")
