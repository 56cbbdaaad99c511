"""The paper's Figure 3: the region, the paths, and the robots at each switching position [m; world frame]."""

import math
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle as Disc
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from clew.figures.ground import MOVES, OVER, Frame, draw_ground, frame_of
from clew.figures.looks import looks_of
from clew.figures.style import BLACK, COLUMN_IN, GREY, HAIR_PT, LOOKS, PAGE_IN, PALE, Chart, legend_below
from clew.story.course import Course
from clew.story.steps import Step, chosen_gap
from protocol.arrays import Floats

HEIGHT_IN_MAX = 4.5
MARGIN_IN, LABELS_IN, ROW_IN, LEGEND_COLUMNS = 0.5, 0.5, 0.13, 3  # room for text of 7 points
WIDE = 0.35  # a frame with less height than this share of its width takes both columns
OPEN: dict[str, Any] = {"markerfacecolor": "none", "markersize": 7.0, "markeredgewidth": 0.8}
HALO = withStroke(linewidth=1.5, foreground="white")
GAP_PT = 4.5  # the number of a gap: smaller than that of the position where its step began
GAP_SHARES = np.linspace(
    0.9, 0.1, 9
)  # of a gap's length: where its number may stand, for gaps lie side by side
LABEL_PT = 5.0  # from a switching position to its number


def region(course: Course) -> Chart:
    """Figure 3 of a run."""
    frame = frame_of(course)
    width_in = PAGE_IN if frame.aspect < WIDE else COLUMN_IN
    rows = math.ceil(len(_legend(course)) / LEGEND_COLUMNS)
    height_in = (width_in - MARGIN_IN) * frame.aspect + LABELS_IN + ROW_IN * rows
    height_in = min(height_in, HEIGHT_IN_MAX)
    return Chart("region", (width_in, height_in), lambda figure: _paint(figure, course, frame))


def chosen_gap_m(step: Step) -> Floats | None:
    """The tangent points of the chosen gap, `(2, 2)`; None: there was no chosen gap."""
    ends = chosen_gap(step.plan)
    return None if ends is None else np.array([(end.x_m, end.y_m) for end in ends])


def draw_robots(axes: Axes, course: Course, places_m: Floats, leader: int, *, size_pt: float) -> None:
    """Draw every robot at its place: its hull to scale and its marker; the leader's is filled."""
    radius_m = course.scenario.fleet.robot_radius_m
    for robot, (look, _) in looks_of(course).items():
        place_m = places_m[robot - 1]
        if radius_m > 0.0:
            hull = Disc(tuple(place_m), radius_m, fill=False, edgecolor=look.colour, linewidth=HAIR_PT)
            hull.set_zorder(OVER)
            axes.add_patch(hull)
        face = look.colour if robot == leader else "white"
        axes.plot(
            *place_m,
            look.marker,
            color=look.colour,
            markerfacecolor=face,
            markersize=size_pt,
            markeredgewidth=HAIR_PT,
            zorder=OVER + 0.1 * (robot == leader),
        )


def _paint(figure: Figure, course: Course, frame: Frame) -> None:
    axes = figure.subplots()
    draw_ground(axes, course, frame, is_numbered=True)
    _draw_gaps(axes, course)
    # On a shared path the first robot is on top, and those below are wider, to be seen on both sides.
    for rank, (robot, (look, _)) in reversed(list(enumerate(looks_of(course).items()))):
        path_m = course.places_m[:, robot - 1]
        width_pt = look.width_pt + (1.5 * HAIR_PT * rank if look in LOOKS else 0.0)
        line = axes.plot(*path_m.T, color=look.colour, linewidth=width_pt, zorder=1.6)
        line[0].set_gid(f"path-{robot}")  # a name for editing the SVG
    moments = [*((stand.t_s, stand.robot) for stand in course.stands), *course.last]
    for t_s, leader in moments:
        draw_robots(axes, course, course.places_at_m(t_s), leader, size_pt=2.2)
    _number_stands(axes, course)
    _mark_recoveries(axes, course)
    axes.set(xlabel="x [m]", ylabel="y [m]")
    legend_below(figure, columns=LEGEND_COLUMNS, handles=_legend(course))


def _draw_gaps(axes: Axes, course: Course) -> None:
    """Draw the chosen gaps, each with its step's number where the numbers before it leave most room."""
    numbers_m = np.empty((0, 2))
    for step in course.steps:
        ends_m = chosen_gap_m(step)
        if ends_m is None:
            continue
        axes.plot(*ends_m.T, "--.", color=BLACK, linewidth=HAIR_PT, markersize=2.5, zorder=1.2)
        places_m = ends_m[0] + np.outer(GAP_SHARES, ends_m[1] - ends_m[0])
        apart_m = np.linalg.norm(places_m[:, None] - numbers_m, axis=2).min(axis=1, initial=np.inf)
        at_m = places_m[int(apart_m.argmax())]
        numbers_m = np.vstack((numbers_m, at_m))
        text = axes.text(at_m[0], at_m[1], f"g{step.number}", ha="center", va="center")
        text.set(fontsize=GAP_PT, color=GREY, path_effects=[HALO], zorder=OVER + 0.9)


def _number_stands(axes: Axes, course: Course) -> None:
    """Draw the number of each switching position, on alternate sides of the path."""
    places_m = np.array([(stand.place.x_m, stand.place.y_m) for stand in course.stands]).reshape(-1, 2)
    for index, place_m in enumerate(places_m):
        way_m = places_m[min(index + 1, len(places_m) - 1)] - places_m[max(index - 1, 0)]
        length_m = float(np.hypot(*way_m)) or 1.0
        side = 1.0 if index % 2 else -1.0
        offset_pt = side * LABEL_PT * np.array((-way_m[1], way_m[0])) / length_m
        axes.annotate(
            course.stands[index].name,
            (place_m[0], place_m[1]),
            (offset_pt[0], offset_pt[1]),
            textcoords="offset points",
            ha=("right", "center", "left")[round(offset_pt[0] / LABEL_PT) + 1],  # away from the path
            va="center",
            fontsize=5.5,
            path_effects=[HALO],
            zorder=OVER + 1.0,
        )


def _mark_recoveries(axes: Axes, course: Course) -> None:
    """Mark the bodies of dead robots, and the places where other robots began to lead."""
    if len(course.times_s) == 0:
        return
    for t_s, robot in course.route_lost:
        place_m = course.places_at_m(t_s)[robot - 1]
        axes.plot(*place_m, "s", color=BLACK, zorder=OVER + 0.5, **OPEN)
    for robot in course.dead:
        place_m = course.places_m[-1, robot - 1]
        hull = Disc(tuple(place_m), course.scenario.fleet.robot_radius_m, color=GREY, zorder=OVER + 0.3)
        axes.add_patch(hull)
        axes.plot(*place_m, "x", color=BLACK, markersize=5.0, markeredgewidth=1.2, zorder=OVER + 0.5)
    for succession in course.recovery.successions:
        place_m = course.places_at_m(succession.recovered_s)[succession.robot - 1]
        axes.plot(*place_m, "o", color=BLACK, zorder=OVER + 0.5, **OPEN)


def _legend(course: Course) -> list[Artist]:
    handles: list[Artist] = [
        Line2D([], [], color=look.colour, linewidth=look.width_pt, marker=look.marker, label=label)
        for look, label in looks_of(course).values()
        if label is not None
    ]
    if any(chosen_gap(step.plan) is not None for step in course.steps):
        handles.append(
            Line2D(
                [],
                [],
                color=BLACK,
                marker=".",
                linestyle="--",
                linewidth=HAIR_PT,
                label="gap chosen (g: in step)",
            )
        )
    bare: dict[str, Any] = {"color": BLACK, "linestyle": ""}
    if course.scenario.goal is not None:
        handles.append(Line2D([], [], marker="*", label="goal", **bare))
    if course.scenario.moving:
        handles.append(Patch(facecolor=PALE, edgecolor=GREY, hatch=MOVES, label="moving, at the start"))
    if course.dead:
        handles.append(Line2D([], [], marker="x", label="dead body", **bare))
    if course.recovery.successions:
        handles.append(Line2D([], [], marker="o", markerfacecolor="none", label="leads from here", **bare))
    if course.route_lost:
        handles.append(Line2D([], [], marker="s", markerfacecolor="none", label="no way on", **bare))
    return handles
