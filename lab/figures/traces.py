"""Clearance and separation of every robot against time, all along the motion [m, s]."""

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from lab.figures.course import Course
from lab.figures.distances import draw_limits
from lab.figures.looks import looks_of
from lab.figures.style import BLACK, COLUMN_IN, Chart, LeftOut, legend_below, limit
from protocol.arrays import Floats
from world.clearance import separations

PANEL_IN, LEGEND_IN = 1.9, 0.6
POINTS_MAX = 500  # along a trace: two to each point (1/72 in) of a column's width
TOUCH_M = 1e-3  # what is nearer is drawn there: a logarithm knows no contact
NEAR = 8.0  # times the limit: what is further away is cut off, for nobody is near


def clearance(course: Course) -> Chart | LeftOut:
    """Each robot's clearance: from obstacles that never move, and while it drives, from those that do."""
    if len(course.times_s) == 0:
        return LeftOut("clearance", "no body was placed")
    panels = []
    if course.scenario.obstacles:
        panels.append(("clearance [m]", course.clearance_m, True))
    if course.scenario.moving:
        panels.append(("to what moves, driving [m]", moving_clearance_m(course), False))
    if not panels:
        return LeftOut("clearance", "there is no obstacle")

    def paint(figure: Figure) -> None:
        for axes, (label, apart_m, has_limits) in zip(_panels(figure, len(panels)), panels, strict=True):
            _draw(axes, course, apart_m)
            if has_limits:
                draw_limits(axes, course)
            _finish(axes, course, label)
            _show_near(axes, apart_m, course.scenario.law.epsilon_m)
        legend_below(figure, columns=4)

    return Chart("clearance", (COLUMN_IN, PANEL_IN * len(panels) + LEGEND_IN), paint)


def separation(course: Course) -> Chart | LeftOut:
    """How far each robot is behind the one ahead of it, hull to hull, and the least of any two."""
    if len(course.times_s) == 0:
        return LeftOut("separation", "no body was placed")
    if len(course.robots) == 1:
        return LeftOut("separation", "there is one robot")

    def paint(figure: Figure) -> None:
        (axes,) = _panels(figure, 1)
        ahead_m, least_m = separations_m(course)
        _draw(axes, course, ahead_m)
        axes.plot(*thinned(course.times_s, least_m), color=BLACK, linewidth=1.0, label="least of any two")
        separation_m = course.scenario.fleet.separation_m
        limit(axes, separation_m, "least allowed")
        _finish(axes, course, "to the robot ahead [m]")
        axes.set_yscale("log")  # strands stretch to metres, and the least allowed is centimetres
        axes.yaxis.set_major_formatter(ScalarFormatter())
        axes.set_ylim(bottom=0.7 * max(min(separation_m, float(least_m.min())), TOUCH_M))
        legend_below(figure, columns=4)

    return Chart("separation", (COLUMN_IN, PANEL_IN + LEGEND_IN), paint)


def moving_clearance_m(course: Course) -> Floats:
    """`(k, n)`: of each hull since the instant before, to the nearest moving obstacle.

    Not a number where the robot stood: the promise is passive, and a robot that stands may be touched.
    """
    movers, radius_m = course.scenario.movers, course.scenario.fleet.robot_radius_m
    first_m = [np.full(len(course.robots), np.nan)]  # since before the first instant nobody moved
    steps = pairwise(zip(course.times_s.tolist(), course.places_m, strict=True))
    since_m = [
        movers.approaches_m(starts_m, ends_m, from_s=from_s, to_s=to_s, near_m=np.inf).min(axis=1)
        for (from_s, starts_m), (to_s, ends_m) in steps
    ]
    drove = np.diff(course.places_m, axis=0, prepend=course.places_m[:1]).any(axis=2)
    return np.where(drove, np.array(first_m + since_m) - radius_m, np.nan)


def separations_m(course: Course) -> tuple[Floats, Floats]:
    """Hull to hull since the instant before: of each robot to the one ahead `(k, n)`, of any two `(k,)`.

    Whoever is in no strand, or leads it, has nobody ahead: not a number.
    """
    ahead_m = np.full(course.clearance_m.shape, np.nan)
    least_m = np.empty(len(course.times_s))
    starts_m = np.concatenate((course.places_m[:1], course.places_m[:-1]))
    for row, t_s in enumerate(course.times_s.tolist()):
        apart_m = (
            separations(starts_m[row], course.places_m[row]) - 2.0 * course.scenario.fleet.robot_radius_m
        )
        least_m[row] = apart_m.min()
        for one, behind in pairwise(course.order_at(t_s)):
            ahead_m[row, behind - 1] = apart_m[one - 1, behind - 1]
    return ahead_m, least_m


def thinned(times_s: Floats, apart_m: Floats) -> tuple[Floats, Floats]:
    """A trace of no more points than can be seen; of those that fall together the nearest stays."""
    if len(times_s) <= POINTS_MAX:
        return times_s, apart_m
    rows = np.array_split(np.arange(len(times_s)), POINTS_MAX)
    kept = np.array(
        [some[np.argmin(np.where(np.isnan(apart_m[some]), np.inf, apart_m[some]))] for some in rows]
    )
    return times_s[kept], apart_m[kept]


def _panels(figure: Figure, count: int) -> list[Axes]:
    return list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])


def _draw(axes: Axes, course: Course, apart_m: Floats) -> None:
    """A line for each robot, until it dies, and a cross there."""
    for robot, (look, label) in looks_of(course).items():
        lived = course.times_s <= course.dead.get(robot, np.inf)
        own_s, own_m = course.times_s[lived], apart_m[lived, robot - 1]
        if np.isnan(own_m).all():
            continue  # it was never near anything of that kind
        axes.plot(
            *thinned(own_s, own_m), color=look.colour, linestyle=look.dashes, lw=look.width_pt, label=label
        )
        if robot in course.dead and len(own_s):
            axes.plot(own_s[-1], own_m[-1], "x", color=BLACK, markersize=5.0, zorder=3.0, clip_on=False)


def _finish(axes: Axes, course: Course, label: str) -> None:
    """Labels; successions as thin lines down."""
    for index, succession in enumerate(course.recovery.successions):
        said = "succession" if index == 0 else None
        axes.axvline(
            succession.recovered_s, color=BLACK, linewidth=0.4, linestyle=(0, (8.0, 4.0)), label=said
        )
    if axes is axes.figure.axes[-1]:
        axes.set_xlabel("time [s]")
    axes.set_ylabel(label)
    axes.margins(x=0.0)


def _show_near(axes: Axes, apart_m: Floats, limit_m: float) -> None:
    """What is far away is cut off."""
    if np.isnan(apart_m).all():
        return  # nobody ever drove
    least_m, most_m = float(np.nanmin(apart_m)), float(np.nanmax(apart_m))
    top_m = 1.05 * min(most_m, max(NEAR * limit_m, 2.0 * least_m))
    axes.set_ylim(min(0.0, least_m), max(top_m, 1.5 * limit_m))
