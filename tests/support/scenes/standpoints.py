"""Standpoints in random worlds: a robot's scan there, and the ground truth by shapely. Not a test file."""

from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np
import shapely
from hypothesis import assume
from hypothesis import strategies as st

from agents.navigation.scan import View, view
from clew.fields.field import BUILDERS, Field, scene
from clew.fields.kinds import Kind
from protocol.arrays import Floats, scan_bearings_rad
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.mission import Mission
from protocol.wire.messages import Scan
from tests.support.stages.one_step import under
from world.geometry.rays import cast
from world.geometry.shapes import Circle, Polygon, Shape, ground_of
from world.scenario.budget import sure_range_m
from world.scenario.corners import sharpest_corner_rad

RADIUS_M, EPSILON_M = 0.15, 0.05
KEEP_M = RADIUS_M + EPSILON_M
RANGE_M_MAX = 4.0
SIZE_M = (3.0, 2.4)
PLACES = st.tuples(st.floats(-0.5, SIZE_M[0] + 0.5), st.floats(0.0, SIZE_M[1]))
KINDS = sorted(set(Kind) - set(BUILDERS))  # what is built needs more ground than this
SEEDS = 5  # of each kind; making a field takes longer than looking around in it
HEADINGS_RAD = np.linspace(-np.pi, np.pi, 60, endpoint=False)
HEADINGS = np.stack([np.cos(HEADINGS_RAD), np.sin(HEADINGS_RAD)], axis=1)


@dataclass(frozen=True)
class Standpoint:
    """A robot in a world; every range has the largest permitted error, of either sign [m; world frame]."""

    shapes: tuple[Shape, ...]
    position: Floats
    directions: int
    range_error_m: float
    chance: int
    radius_m: float = RADIUS_M
    epsilon_m: float = EPSILON_M

    @cached_property
    def mission(self) -> Mission:
        """The scenario as loaded, with this world and sensor."""
        return under(
            "certified",
            robot_radius_m=self.radius_m,
            epsilon_m=self.epsilon_m,
            mu0_m=self.epsilon_m / 10.0,
            directions=self.directions,
            range_m_max=min(RANGE_M_MAX, sure_range_m(self.shapes, self.directions)),
            range_error_m_max=self.range_error_m,
            sharpest_corner_rad=sharpest_corner_rad(self.shapes),
        )

    @cached_property
    def view(self) -> View:
        """The scan."""
        limit_m = self.mission.range_m_max
        bearings_rad = scan_bearings_rad(self.directions)
        true_m = cast(
            ground_of(self.shapes), self.position, bearings_rad, range_m_max=limit_m, discs=np.empty((0, 3))
        )
        signs = np.random.default_rng(self.chance).choice([-1.0, 1.0], size=len(true_m))
        read_m = np.where(
            true_m < limit_m, np.clip(true_m + signs * self.range_error_m, 0.0, limit_m), limit_m
        )
        x_m, y_m = self.position.tolist()
        scan = Scan(
            t_s=0.0,
            fence=Fence(),
            pose=Pose(x_m=x_m, y_m=y_m, heading_rad=0.0),
            ranges_m=tuple(read_m.tolist()),
        )
        return view(scan, range_m_max=limit_m)

    @property
    def free(self) -> shapely.Polygon:
        """The free polygon of the scan."""
        return shapely.Polygon(self.view.points)

    def moves(self, lengths_m: Floats) -> Floats:
        """A straight move in each of `HEADINGS`, as shapely's lines."""
        ends = self.position + lengths_m[:, None] * HEADINGS
        lines = shapely.linestrings(np.stack([np.broadcast_to(self.position, ends.shape), ends], axis=1))
        return np.asarray(lines)

    def true_distance_m(self, lines: Floats) -> Floats:
        """The least distance between each line and any shape: exact, since discs are given by centres."""
        return np.asarray(np.min([_distance_m(lines, shape) for shape in self.shapes], axis=0))

    @property
    def off_m(self) -> float:
        """The distance from the robot's centre to the nearest shape."""
        return float(self.true_distance_m(np.array([shapely.Point(self.position)]))[0])


def _distance_m(lines: Floats, shape: Shape) -> Floats:
    match shape:
        case Circle():
            off_m = shapely.distance(lines, shapely.Point(shape.centre_m)) - shape.radius_m
            return np.asarray(np.maximum(off_m, 0.0))
        case Polygon():
            return np.asarray(shapely.distance(lines, shapely.Polygon(shape.vertices_m)))
        case _:
            raise AssertionError(shape)  # fields have no other


@cache
def field_shapes(kind: Kind, seed: int) -> tuple[Shape, ...]:
    """A crowded field; with an even seed its obstacles overlap into walls that are not convex."""
    overlap = kind is not Kind.CORRIDORS and seed % 2 == 0
    drawn = scene(
        Field(
            kind=kind, seed=seed, size_m=SIZE_M, density=0.25, least_width_m=0.0 if overlap else 2.5 * KEEP_M
        )
    )
    circles = [Circle(centre_m=(x, y), radius_m=radius_m) for x, y, radius_m in drawn["circles"]]
    return (*circles, *(Polygon(vertices_m=tuple(ring)) for ring in (*drawn["polygons"], *drawn["walls"])))


@st.composite
def standpoints(draw: st.DrawFn) -> Standpoint:
    """Anywhere in a field, clear of all shapes; in half of the cases moved to the nearest until it touches.

    It touches with its hull or with its clearance, so that rounding in the last bits decides.
    """
    shapes = field_shapes(draw(st.sampled_from(KINDS)), draw(st.integers(0, SEEDS - 1)))
    places = draw(st.lists(PLACES, min_size=6, max_size=6))  # about every second one is clear
    directions = draw(st.sampled_from([24, 90, 360]))
    error_m, chance = draw(st.sampled_from([0.0, 0.00125, 0.01])), draw(st.integers(0, 2**16))
    touch_m = draw(st.sampled_from([None, RADIUS_M + 1e-3, KEEP_M, KEEP_M + error_m + 1e-3]))
    candidates = [Standpoint(shapes, np.array(place), directions, error_m, chance) for place in places]
    there = next((each for each in candidates if each.off_m > (touch_m or RADIUS_M)), candidates[0])
    assume(there.off_m > (touch_m or RADIUS_M))
    if touch_m is not None:
        there = replace(there, position=_drawn_up(there, touch_m))
    assume(there.mission.range_m_max >= 2.0 * KEEP_M)  # the loader refuses the rest
    return there


def _drawn_up(there: Standpoint, touch_m: float) -> Floats:
    """A place on the way to the nearest shape, at this distance from it."""
    point = shapely.Point(there.position)
    nearest = min(there.shapes, key=lambda shape: float(_distance_m(np.array([point]), shape)[0]))
    match nearest:
        case Circle():
            target = np.array(nearest.centre_m)
        case Polygon():
            target = shapely.get_coordinates(
                shapely.shortest_line(point, shapely.Polygon(nearest.vertices_m))
            )[1]
        case _:
            raise AssertionError(nearest)  # fields have no other
    towards = target - there.position
    return np.asarray(there.position + towards / np.hypot(*towards) * (there.off_m - touch_m))
