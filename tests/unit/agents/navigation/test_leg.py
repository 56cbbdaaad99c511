"""The clearance of the straight way ahead, from a robot's own scan."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.leg import certain_clearance_m, certain_clearance_m_min, seen_clearance_m
from tests.support.stages.one_step import look_around, under
from world.geometry.shapes import Circle

MISSION = under("certified", robot_radius_m=0.1, range_error_m_max=0.005)
NEAR_M = MISSION.robot_radius_m + MISSION.clear_m
POST_M = 0.02  # radius of the post
AHEAD = np.array([0.9, 0.0])


def seen(bearing_rad: float, off_m: float) -> tuple[float, float]:
    """The seen and the certain clearance of the way ahead, with a post whose face is `off_m` away."""
    centre_m = (off_m + POST_M) * np.array([np.cos(bearing_rad), np.sin(bearing_rad)])
    post = Circle(centre_m=(float(centre_m[0]), float(centre_m[1])), radius_m=POST_M)
    view = look_around([post], MISSION)
    return seen_clearance_m(view, AHEAD, MISSION), certain_clearance_m(view, AHEAD, MISSION)


@given(st.floats(2.0, 4.0), st.floats(0.0, 0.95))
def test_a_post_that_may_be_too_near_does_not_matter_if_the_way_leads_away(
    bearing_rad: float, share: float
) -> None:
    doubt_m = MISSION.range_error_m_max
    assert min(seen(bearing_rad, NEAR_M - 0.02 + share * 0.02)) >= MISSION.clear_m, "the post is too near"
    assert seen(bearing_rad, NEAR_M + share * doubt_m)[1] >= certain_clearance_m_min(MISSION), (
        "the post may be too near"
    )


@pytest.mark.parametrize("off_m", [NEAR_M - 0.02, NEAR_M + 0.002])
def test_a_post_as_near_on_the_way_ahead_does_matter(off_m: float) -> None:
    assert max(seen(0.0, off_m)) < 0.0
