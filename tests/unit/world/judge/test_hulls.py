"""The hulls of several fleets: what a robot sees of the others."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from protocol.arrays import Floats, scan_bearings_rad
from tests.support.scenes.world_scenarios import scenario
from world.geometry.rays import cast
from world.geometry.shapes import ground_of
from world.judge.hulls import AllHulls

RANGE_M_MAX = 4.0
FLEETS = ("a", "b", "c")
OPEN = ground_of([])
places = st.lists(
    st.tuples(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0)), min_size=6, max_size=6, unique=True
).map(np.array)


def seen_m(place_m: Floats, discs: Floats) -> Floats:
    return cast(OPEN, place_m, scan_bearings_rad(360), range_m_max=RANGE_M_MAX, discs=discs)


@given(places)
def test_a_scan_of_the_hulls_in_range_is_a_scan_of_all_hulls_but_those_of_the_own_fleet(
    all_m: Floats,
) -> None:
    each = scenario()
    all_hulls = AllHulls(dict.fromkeys(FLEETS, each))
    all_hulls.move({fleet: all_m[2 * row : 2 * row + 2] for row, fleet in enumerate(FLEETS)}, t_s=0.02)
    hulls = np.column_stack((all_m, np.full(len(all_m), each.fleet.robot_radius_m)))
    for row, fleet in enumerate(FLEETS):
        others = np.delete(hulls, [2 * row, 2 * row + 1], axis=0)
        shown = all_hulls.others_of(fleet)(all_m[2 * row], RANGE_M_MAX)
        assert len(shown) <= len(others)
        assert np.array_equal(seen_m(all_m[2 * row], shown), seen_m(all_m[2 * row], others))
