"""Scans for tests: from ranges, and random ones for hypothesis. Not a test file."""

from hypothesis import strategies as st

from agents.navigation.scan import View, view
from protocol.fence import Fence
from protocol.frames import Pose
from protocol.wire.messages import Scan

RANGE_M_MAX = 4.0
ORIGIN = Pose(x_m=0.0, y_m=0.0, heading_rad=0.0)
NOTHING_M = RANGE_M_MAX


def view_of(ranges_m: list[float], at: Pose = ORIGIN) -> View:
    """A robot's scan with these ranges, anti-clockwise from bearing -pi."""
    return view(Scan(t_s=0.0, fence=Fence(), pose=at, ranges_m=tuple(ranges_m)), range_m_max=RANGE_M_MAX)


def turned(ranges_m: list[float], directions: int) -> list[float]:
    """The same surroundings, turned anti-clockwise by this many directions."""
    cut = -directions % len(ranges_m)
    return ranges_m[cut:] + ranges_m[:cut]


@st.composite
def ranges(draw: st.DrawFn) -> list[float]:
    """Runs of hits at one range each, and runs without hits, so that obstacles of all sizes occur."""
    runs = st.tuples(
        st.one_of(st.just(NOTHING_M), st.floats(0.2, NOTHING_M, exclude_max=True)), st.integers(1, 8)
    )
    measured = [
        each for range_m, size in draw(st.lists(runs, min_size=1, max_size=10)) for each in [range_m] * size
    ]
    return (measured * 8)[: max(8, len(measured))]
