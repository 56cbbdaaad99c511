"""A strand that forms anew again and again, under message faults: no two hulls meet."""

from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.liveness.reason import Turnabout
from protocol.frames import Point
from protocol.timeline import MessageRefused
from tests.support.stages.member_stage import MemberStage, row
from tests.support.stages.one_step import under
from tests.support.strategies.examples import examples

MISSION = under(
    "certified",
    robots=4,
    robot_radius_m=0.1,
    separation_m=0.1,
    goal=Point(x_m=2.0, y_m=2.0),
    goal_tolerance_m=0.1,
    directions=180,
)
# The nearest queue that a scenario allows, one with a grant's length more, and one far apart.
spacings_m = st.sampled_from([0.31, 0.36, 0.6])


def turned(stage: MemberStage, back: float) -> Turnabout:
    """The tail leads, at once or when the others have come back by a share of the path."""
    tail_m, end_m = stage.members[stage.order[-1]].progress_m, stage.leader.progress_m
    return Turnabout(cut_m=0.0 if back else tail_m, end_m=end_m, back_by_m=back * end_m)


@given(st.integers(0, 2**16), spacings_m, st.sampled_from([0.0, 0.3, 0.8]))
@settings(max_examples=examples(25))
def test_no_message_fault_brings_robots_of_a_strand_that_turns_round_too_near(
    seed: int, spacing_m: float, loss: float
) -> None:
    stage, chance = MemberStage(MISSION, row(4, spacing_m=spacing_m), (1, 2, 3, 4)), Random(seed)
    stage.loss, stage.odd, stage.seed = loss, 0.4, seed
    for _ in range(6):
        stage.run(chance.choice([0.1, 0.5, 2.0, 6.0]))
        assert stage.records(MessageRefused) == [], "nothing true is refused"
        turnabout = chance.choice([None, turned(stage, 0.0), turned(stage, chance.random())])
        stage.reform(turnabout)
        for member in stage.members.values():
            assert member.reason is None, "each stands at its place"


@pytest.mark.parametrize("seed", range(3))
def test_a_strand_that_was_turned_round_twice_still_comes_to_the_goal(seed: int) -> None:
    stage = MemberStage(MISSION, row(4, spacing_m=0.36), (1, 2, 3, 4), loss=0.3, odd=0.3, seed=seed)
    for _ in range(2):
        stage.run(3.0)
        stage.reform(turned(stage, 0.0))
    stage.run(120.0, turns=True)
    assert all(member.arrived for member in stage.members.values())
