"""Random shapes for hypothesis, and shapely's view of ours. Not a test file."""

import math

import numpy as np
import shapely
from hypothesis import settings
from hypothesis import strategies as st
from shapely import affinity

from world.geometry.shapes import Circle, Ellipse, Polygon, Shape

# Ellipses as shapely sees them: 512 chords to a quarter circle fall short of it by
# 1 - cos(pi / 4 / 512) = 1.2e-6 of a semi-axis, and those here are at most 2 m.
QUARTER_CHORDS = 512
ORACLE_ERROR_M = 3e-6

patiently = settings(deadline=None)  # shapely is slow, and the machine may be busy

coordinates_m = st.floats(-4.0, 4.0)
points = st.tuples(coordinates_m, coordinates_m)
sizes_m = st.floats(0.05, 2.0)

circles = st.builds(Circle, centre_m=points, radius_m=sizes_m)
ellipses = st.builds(
    Ellipse,
    centre_m=points,
    semi_axes_m=st.tuples(sizes_m, sizes_m),
    rotation_rad=st.floats(-math.pi, math.pi),
)


@st.composite
def polygons(draw: st.DrawFn) -> Polygon:
    """A star-shaped ring, mostly not convex, in either sense."""
    radii_m = draw(st.lists(sizes_m, min_size=3, max_size=9))
    bearings_rad = np.linspace(0.0, math.tau, len(radii_m), endpoint=False) + draw(st.floats(0.0, 1.0))
    x_m, y_m = draw(points)
    ring = [
        (x_m + r * math.cos(bearing), y_m + r * math.sin(bearing))
        for r, bearing in zip(radii_m, bearings_rad.tolist(), strict=True)
    ]
    return Polygon(vertices_m=tuple(ring if draw(st.booleans()) else ring[::-1]))


shapes: st.SearchStrategy[Shape] = st.one_of(circles, ellipses, polygons())
grounds = st.lists(shapes, max_size=5)


def as_shapely(shape: Shape) -> shapely.Geometry:
    """The same shape as a shapely geometry."""
    match shape:
        case Circle():
            return shapely.Point(shape.centre_m).buffer(shape.radius_m, quad_segs=QUARTER_CHORDS)
        case Ellipse():
            unit = shapely.Point(0.0, 0.0).buffer(1.0, quad_segs=QUARTER_CHORDS)
            scaled = affinity.scale(unit, *shape.semi_axes_m)
            turned = affinity.rotate(scaled, shape.rotation_rad, origin=(0.0, 0.0), use_radians=True)
            return affinity.translate(turned, *shape.centre_m)
        case Polygon():
            return shapely.Polygon(shape.vertices_m)
