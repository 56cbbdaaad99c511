"""The ground in a figure: obstacles, bounds and goal, in a frame around the run [m; world frame]."""

from dataclasses import dataclass

import numpy as np
import shapely
from matplotlib.axes import Axes
from matplotlib.patches import Circle as Disc
from matplotlib.patches import Ellipse as Oval
from matplotlib.patches import Patch, Rectangle
from matplotlib.patches import Polygon as Ring
from matplotlib.patheffects import withStroke

from clew.figures.style import BLACK, GREY, HAIR_PT, PALE
from clew.story.course import Course
from protocol.arrays import Floats
from world.geometry.shapes import Circle, Ellipse, Polygon, Shape
from world.scenario.scenario import Scenario

MOVES = "////"  # the hatching of obstacles that move
ROOM = 0.02  # of the longer side, from the middle of an obstacle: room for a number of the usual size
NUMBER_PT, SMALL_PT = 7.0, 4.5
MARGIN = 0.06  # of the longer side
WHOLE_SHARE = 0.4  # a run that covers less of the ground is enlarged
OVER, UNDER = 2.0, 1.0  # layers: bodies and labels; ground


@dataclass(frozen=True, slots=True)
class Frame:
    """The part of the ground that a figure shows."""

    low_m: Floats
    high_m: Floats

    @property
    def aspect(self) -> float:
        """Height over width."""
        width_m, height_m = self.high_m - self.low_m
        return float(height_m / width_m)

    @property
    def side_m(self) -> float:
        """The longer side."""
        return float((self.high_m - self.low_m).max())

    def holds(self, place_m: Floats) -> bool:
        """Whether a place is inside."""
        return bool((place_m >= self.low_m).all() and (place_m <= self.high_m).all())


def frame_of(course: Course, margin: float = MARGIN) -> Frame:
    """The whole ground, or only the part that the run covered if that is small."""
    scenario = course.scenario
    run_m = _run_m(course)
    whole_m = np.vstack((run_m, *map(_corners_m, scenario.obstacles), *_bounds_m(scenario)))
    run_span_m, whole_span_m = np.ptp(run_m, axis=0).max(), np.ptp(whole_m, axis=0).max()
    shown_m = whole_m if run_span_m > WHOLE_SHARE * whole_span_m else run_m
    span_m = np.ptp(shown_m, axis=0)
    # A run along a line gets some ground on both sides.
    margin_m = np.maximum(margin * span_m.max(), (0.35 * span_m.max() - span_m) / 2.0)
    return Frame(shown_m.min(axis=0) - margin_m, shown_m.max(axis=0) + margin_m)


def draw_ground(
    axes: Axes, course: Course, frame: Frame, *, t_s: float = 0.0, is_numbered: bool = False
) -> None:
    """Draw obstacles, bounds and goal; moving obstacles at their places at `t_s`, with their tracks."""
    scenario = course.scenario
    for row, shape in enumerate(scenario.obstacles):
        axes.add_patch(patch_of(shape))
        if is_numbered:
            _number(axes, frame, shape, row + 1)
    for moving, place_m in zip(scenario.moving, scenario.movers.places_m(t_s), strict=True):
        track_m = np.array(moving.track)[:, 1:]
        axes.plot(*track_m.T, color=GREY, linestyle=":", linewidth=0.8, zorder=UNDER)
        patch = patch_of(moving.outline, offset_m=place_m)
        patch.set(hatch=MOVES)
        axes.add_patch(patch)
    for low_m, high_m in _bounds_m(scenario):
        box = Rectangle(
            (low_m[0], low_m[1]), *(high_m - low_m), fill=False, linestyle="-.", linewidth=HAIR_PT
        )
        axes.add_patch(box)
    if scenario.goal is not None:
        at_m = scenario.goal.at_m
        ring = Disc(at_m, scenario.goal.tolerance_m, fill=False, linestyle="--", linewidth=HAIR_PT)
        axes.add_patch(ring)
        axes.plot(*at_m, "*", color=BLACK, markersize=5.0, markeredgewidth=0.0, zorder=UNDER)
    axes.set(xlim=(frame.low_m[0], frame.high_m[0]), ylim=(frame.low_m[1], frame.high_m[1]), aspect="equal")


def _number(axes: Axes, frame: Frame, shape: Shape, number: int) -> None:
    """Draw an obstacle's number on it, where there is most room; a small obstacle gets a small number."""
    middle_m, room_m = _middle_m(shape)
    if frame.holds(middle_m):
        size = NUMBER_PT if room_m > ROOM * frame.side_m else SMALL_PT
        text = axes.text(middle_m[0], middle_m[1], str(number), ha="center", va="center", fontsize=size)
        text.set(
            zorder=OVER, path_effects=[withStroke(linewidth=1.5, foreground=PALE)], gid=f"obstacle-{number}"
        )


def _middle_m(shape: Shape) -> tuple[Floats, float]:
    """The place in a shape that is farthest from its edge, and how far."""
    match shape:
        case Circle():
            return np.array(shape.centre_m), shape.radius_m
        case Ellipse():
            return np.array(shape.centre_m), min(shape.semi_axes_m)
        case Polygon():
            spoke = shapely.maximum_inscribed_circle(shapely.Polygon(shape.ring_m))
            return np.array(spoke.coords[0]), float(spoke.length)


def patch_of(shape: Shape, offset_m: Floats | tuple[float, float] = (0.0, 0.0)) -> Patch:
    """An obstacle as a matplotlib patch."""
    look = {"facecolor": PALE, "edgecolor": GREY, "linewidth": HAIR_PT, "zorder": UNDER - 0.5}
    match shape:
        case Circle():
            return Disc(tuple(np.add(shape.centre_m, offset_m)), shape.radius_m, **look)
        case Ellipse():
            width_m, height_m = 2.0 * np.array(shape.semi_axes_m)
            centre_m = tuple(np.add(shape.centre_m, offset_m))
            return Oval(centre_m, width_m, height_m, angle=np.degrees(shape.rotation_rad), **look)
        case Polygon():
            return Ring(shape.ring_m + offset_m, closed=True, **look)


def _run_m(course: Course) -> Floats:
    """All places that robots visited or planned to visit."""
    scenario = course.scenario
    starts_m = [(pose.x_m, pose.y_m) for pose in scenario.fleet.poses()]
    goals_m = [] if scenario.goal is None else [scenario.goal.at_m]
    tracks_m = [(x_m, y_m) for moving in scenario.moving for _, x_m, y_m in moving.track]
    return np.vstack((np.array([*starts_m, *goals_m, *tracks_m]), course.places_m.reshape(-1, 2)))


def _bounds_m(scenario: Scenario) -> list[Floats]:
    bounds = scenario.bounds
    if bounds is None:
        return []
    return [np.array([(bounds.x_m_min, bounds.y_m_min), (bounds.x_m_max, bounds.y_m_max)])]


def _corners_m(shape: Shape) -> Floats:
    """Points that span a shape's bounding box; their mean is near its middle."""
    match shape:
        case Circle():
            centre_m, reach_m = np.array(shape.centre_m), np.full(2, shape.radius_m)
        case Ellipse():
            (a, b), turn = shape.semi_axes_m, shape.rotation_rad
            centre_m = np.array(shape.centre_m)
            reach_m = np.hypot([a * np.cos(turn), a * np.sin(turn)], [b * np.sin(turn), b * np.cos(turn)])
        case Polygon():
            return shape.ring_m
    return np.vstack((centre_m - reach_m, centre_m + reach_m))
