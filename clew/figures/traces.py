"""Clearance and separation of every robot against time, along the whole motion [m, s]."""

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
POINTS_MAX = 500  # per trace: two per point (1/72 in) of a column's width
ALONE_PT = 2.0
TICKS = (1.0, 2.0, 5.0)  # of each power of ten
TOUCH_M = 1e-3  # smaller distances are drawn here: a logarithm has no 0
ROOM = 1.4  # factor of free room above and below, on a logarithmic axis
NEAR = 8.0  # times the limit: larger distances are cut off, as they are uncritical


def clearance(course: Course) -> Chart | LeftOut:
    """Each robot's clearance from fixed obstacles and, while it drives, from moving obstacles."""
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
    """The distance of each robot to the one ahead, hull to hull, and the least distance of any two.

    Unknown hulls count as points, without a required distance.
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
        elif hulls_known:  # a logarithmic axis has no 0
            axes.plot([], [], linestyle="", label="required, above 0 m")
        _finish(axes, course, f"to the robot ahead{'' if hulls_known else ', centres'} [m]")
        legend_below(figure, columns=3)

    return Chart("separation", (COLUMN_IN, PANEL_IN + LEGEND_IN), paint)


def moving_clearance_m(course: Course) -> Floats:
    """`(k, n)`: the least distance of each hull to a moving obstacle since the previous instant.

    NaN while the robot stood: the promise is passive, so a standing robot may be touched.
    """
    movers, radius_m = course.scenario.movers, course.scenario.fleet.robot_radius_m
    first_m = [np.full(len(course.robots), np.nan)]  # before the first instant no robot moved
    steps = pairwise(zip(course.times_s.tolist(), course.places_m, strict=True))
    since_m = [
        movers.approaches_m(starts_m, ends_m, from_s=from_s, to_s=to_s, near_m=np.inf).min(axis=1)
        for (from_s, starts_m), (to_s, ends_m) in steps
    ]
    drove = np.diff(course.places_m, axis=0, prepend=course.places_m[:1]).any(axis=2)
    return np.where(drove, np.array(first_m + since_m) - radius_m, np.nan)


def separations_m(course: Course) -> tuple[Floats, Floats]:
    """The least distance of hulls since the previous instant: to the robot ahead `(k, n)`, of any two `(k,)`.

    NaN for a robot that is in no strand or leads it.
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
    """A trace with no more points than are visible; of points that coincide, the nearest one stays."""
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
    """Draw a line for each robot until its body stops for good: a marker at its least, a cross at its death.

    A single value between unknown ones is drawn as a point, because a line needs two.
    """
    for robot, (look, label) in looks_of(course).items():
        until_s, died_s = course.body_end_s(robot), course.dead.get(robot)
        lived = course.times_s <= until_s
        own_s, own_m = thinned(course.times_s[lived], apart_m[lived, robot - 1])
        if np.isnan(own_m).all():
            continue  # there was never anything of this kind near it
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
    """Marks the numbers of a trace between two NaNs."""
    known: NDArray[np.bool_] = np.pad(np.isfinite(apart_m), 1)
    return known[1:-1] & ~known[:-2] & ~known[2:]


def _scale(axes: Axes, apart_m: Floats, required_m: float) -> None:
    """Use a logarithmic axis: strands stretch to metres, while required distances are centimetres."""
    lowest_m = max(min(required_m or np.inf, float(np.nanmin(apart_m))), TOUCH_M)
    axes.set_yscale("log")
    axes.set_ylim(lowest_m / ROOM, max(lowest_m, float(np.nanmax(apart_m))) * ROOM)
    axes.yaxis.set_major_locator(LogLocator(subs=TICKS))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda length_m, _: f"{length_m:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _finish(axes: Axes, course: Course, label: str) -> None:
    """Draw labels, and successions as thin vertical lines."""
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
    """Cut off large distances."""
    if np.isnan(apart_m).all():
        return  # no robot ever drove
    least_m, most_m = float(np.nanmin(apart_m)), float(np.nanmax(apart_m))
    top_m = 1.05 * min(most_m, max(NEAR * limit_m, 2.0 * least_m))
    axes.set_ylim(min(0.0, least_m), max(top_m, 1.5 * limit_m))
