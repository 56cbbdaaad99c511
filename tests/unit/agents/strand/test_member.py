"""A strand that turns round under message faults: no collisions, and one epoch moves at a time."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.stages.turning_stage import ORDER, TurningStage

ROUNDING_M = 1e-7  # of about 100 arc lengths, each with the touching tolerance
ROUNDS_MAX = 60  # far more than needed: each robot needs one message, and almost half of them arrive

shares = st.one_of(st.just(1.0), st.floats(0.0, 1.0))
actions = st.lists(
    st.one_of(
        st.tuples(st.just("round"), st.integers(0, 2**16), st.just(0.0)),
        st.tuples(st.just("round"), st.integers(0, 2**16), st.just(0.0)),
        st.tuples(st.just("live"), st.sampled_from(ORDER), shares),
        st.tuples(st.just("deliver"), st.integers(0, 50), shares),
        st.tuples(st.just("step"), st.floats(0.1, 2.0), st.floats(-math.pi, math.pi)),
        st.tuples(st.just("turn"), st.sampled_from([0.1, 0.5, 1.0]), st.just(0.0)),
    ),
    max_size=80,
)
# The nearest queue that a scenario allows, one with a grant's length more, and one far apart.
spacings_m = st.sampled_from([0.3, 0.33, 0.4, 1.0])


@given(spacings_m, actions)
@settings(max_examples=100)
def test_no_message_fault_breaks_a_rule_of_a_strand_that_turns_round(
    spacing_m: float, actions: list[tuple[str, float, float]]
) -> None:
    stage = TurningStage(spacing_m)
    for action in actions:
        stage.act(*action)
        stage.check(spacing_m, ROUNDING_M)


@pytest.mark.parametrize("spacing_m", [0.3, 0.4, 1.0])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_if_some_messages_arrive_all_robots_take_their_places_in_the_next_epoch(
    seed: int, spacing_m: float
) -> None:
    stage = TurningStage(spacing_m)
    for turn in range(1, 4):
        for index in range(ROUNDS_MAX):
            if stage.turns < turn:
                stage.turn(1.0)
            stage.round(1000 * seed + ROUNDS_MAX * turn + index)
            stage.check(spacing_m, ROUNDING_M)
            if min(stage.epochs) > turn:
                break
        assert min(stage.epochs) > turn
