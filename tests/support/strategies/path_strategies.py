"""Random paths for hypothesis: hairpins, loops, corners of all kinds, repeated vertices. Not a test file."""

import math

from hypothesis import strategies as st

from protocol.frames import Point
from protocol.path import Path

# Tenths of metres make vertices meet, segments lie on one another, and corners go straight back.
tenths = st.integers(-20, 20).map(lambda tenth: tenth / 10.0)
places = st.builds(Point, x_m=tenths, y_m=tenths)
turns_rad = st.one_of(
    st.floats(-math.pi, math.pi), st.sampled_from([0.0, math.pi, math.pi / 2, -math.pi / 2, 3.0])
)
strides_m = st.one_of(st.floats(0.05, 1.5), st.just(0.0))


@st.composite
def walks(draw: st.DrawFn) -> Path:
    """A path in which each corner is a turn and a stride from the last, so that it winds about itself."""
    path = Path([Point(x_m=0.0, y_m=0.0)])
    x_m, y_m, heading_rad = 0.0, 0.0, 0.0
    for turn_rad, stride_m in draw(st.lists(st.tuples(turns_rad, strides_m), min_size=1, max_size=11)):
        heading_rad += turn_rad
        x_m, y_m = x_m + stride_m * math.cos(heading_rad), y_m + stride_m * math.sin(heading_rad)
        path.extend(Point(x_m=x_m, y_m=y_m))
    return path


def paths() -> st.SearchStrategy[Path]:
    """Paths of 2 to 12 vertices."""
    return st.one_of(st.lists(places, min_size=2, max_size=12).map(Path), walks())
