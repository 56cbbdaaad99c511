"""Clearance and separation of every robot against time, all along the motion [m, s]."""

from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from clew.figures.distances import draw_limits
from clew.figures.looks import looks_of
from clew.figures.style import BLACK, COLUMN_IN, Chart, LeftOut, legend_below, limit
from clew.story.course import Course
from protocol.arrays import Floats
from world.geometry.clearance import separations
from world.judge.monitor import Promises

CLEARANCE = "clearance"
PANEL_IN, LEGEND_IN = 1.9, 0.6
POINTS_MAX = 500  # along a trace: two to each point (1/72 in) of a column's width
ALONE_PT = 2.0
TICKS = (1.0, 2.0, 5.0)  # of each power of ten
TOUCH_M = 1e-3  # what is nearer is drawn there: a logarithm knows no contact
ROOM = 1.4  # on a logarithm, above and below
NEAR = 8.0  # times the limit: what is further away is cut off, for nobody is near


def clearance(course: Course) -> Chart | LeftOut:
    """Each robot's clearance: from obstacles that never move, and while it drives, from those that do."""
    if len(course.times_s) == 0:
        return LeftOut(CLEARANCE, "no body was placed")
    panels = []
    if course.scenario.obstacles:
        panels.append(("clearance [m]", course.clearance_m, True))
    if course.scenario.moving:
        panels.append(("to what moves, driving [m]", moving_clearance_m(course), False))
    if not panels:
        return LeftOut(CLEARANCE, "there is no obstacle")

    def paint(figure: Figure) -> None:
        for axes, (label, apart_m, has_limits) in zip(_panels(figure, len(panels)), panels, strict=True):
            _draw(axes, course, apart_m)
            if has_limits:
                draw_limits(axes, course)
            _finish(axes, course, label)
            _show_near(axes, apart_m, course.scenario.law.epsilon_m)
        legend_below(figure, columns=4)

    return Chart(CLEARANCE, (COLUMN_IN, PANEL_IN * len(panels) + LEGEND_IN), paint)


def separation(course: Course, *, hulls_known: bool = True) -> Chart | LeftOut:
    """How far each robot is behind the one ahead of it, hull to hull, and the least of any two.

    Where hulls are not known they are points, and nothing is known to be required.
    """
    if len(course.times_s) == 0:
        return LeftOut("separation", "no body was placed")
    if len(course.robots) == 1:
        return LeftOut("separation", "there is one robot")

    def paint(figure: Figure) -> None:
        (axes,) = _panels(figure, 1)
        ahead_m, least_m = separations_m(course)
        required_m = Promises.of(course.scenario).separation_m_required
        _scale(axes, np.column_stack((ahead_m, least_m)), required_m)
        _draw(axes, course, ahead_m)
        axes.plot(*thinned(course.times_s, least_m), color=BLACK, linewidth=1.0, label="least of any two")
        if required_m > 0.0:
            limit(axes, required_m, f"required, {required_m:.3f} m")
        elif hulls_known:  # a logarithm knows no 0
            axes.plot([], [], linestyle="", label="required, above 0 m")
        _finish(axes, course, f"to the robot ahead{'' if hulls_known else ', centres'} [m]")
        legend_below(figure, columns=3)

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
    """A line for each robot until its body stands for good: its marker at the least, a cross at its death.

    What is known at one instant and at none beside it is a point: a line needs two.
    """
    for robot, (look, label) in looks_of(course).items():
        until_s, died_s = course.body_end_s(robot), course.dead.get(robot)
        lived = course.times_s <= until_s
        own_s, own_m = thinned(course.times_s[lived], apart_m[lived, robot - 1])
        if np.isnan(own_m).all():
            continue  # it was never near anything of that kind
        axes.plot(
            own_s,
            own_m,
            color=look.colour,
            linestyle=look.dashes,
            linewidth=look.width_pt,
            marker=look.marker,
            markevery=[int(np.nanargmin(own_m))],
            label=label,
        )
        alone = _alone(own_m)
        axes.plot(own_s[alone], own_m[alone], ".", color=look.colour, markersize=ALONE_PT)
        if died_s is not None:
            row = min(int(np.searchsorted(own_s, died_s)), len(own_s) - 1)
            axes.plot(own_s[row], own_m[row], "x", color=BLACK, markersize=5.0, zorder=3.0, clip_on=False)


def _alone(apart_m: Floats) -> NDArray[np.bool_]:
    """Which of a trace are numbers between two that are not."""
    known: NDArray[np.bool_] = np.pad(np.isfinite(apart_m), 1)
    return known[1:-1] & ~known[:-2] & ~known[2:]


def _scale(axes: Axes, apart_m: Floats, required_m: float) -> None:
    """A logarithm, for strands stretch to metres, and what is required is centimetres."""
    lowest_m = max(min(required_m or np.inf, float(np.nanmin(apart_m))), TOUCH_M)
    axes.set_yscale("log")
    axes.set_ylim(lowest_m / ROOM, max(lowest_m, float(np.nanmax(apart_m))) * ROOM)
    axes.yaxis.set_major_locator(LogLocator(subs=TICKS))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda length_m, _: f"{length_m:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


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
