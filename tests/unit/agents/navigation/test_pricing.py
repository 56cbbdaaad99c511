"""What it costs to drive through cells: the same, however the costs came about."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from agents.navigation.grid import Grid
from agents.navigation.pricing import Pricing

CELL_M = 0.1
SHAPE = (6, 5)
OF = Grid(np.array([-1.0, -0.5]), SHAPE, CELL_M)
rooms = st.lists(st.sampled_from([-0.2, -0.03, 0.1, 0.25, np.inf]), min_size=30, max_size=30)
changes = st.lists(st.tuples(st.integers(0, 29), st.sampled_from([-0.2, 0.1, np.inf])), max_size=12)


@given(rooms, st.lists(changes, max_size=3))
def test_costs_after_changes_are_those_of_a_new_pricing(
    room: list[float], later: list[list[tuple[int, float]]]
) -> None:
    pricing, now = Pricing(OF), np.array(room)
    pricing.graph(now.reshape(SHAPE))
    for each in later:
        for cell, value in each:
            now[cell] = value
        found = pricing.graph(now.reshape(SHAPE))
        assert (found.data == Pricing(OF).graph(now.reshape(SHAPE)).data).all()


def test_a_pricing_keeps_no_reference_to_the_room() -> None:
    pricing, room = Pricing(OF), np.full(SHAPE, np.inf)
    pricing.graph(room)
    room[2, 2] = -1.0
    assert (
        np.isinf(pricing.graph(room).data).sum()
        > np.isinf(Pricing(OF).graph(np.full(SHAPE, np.inf)).data).sum()
    )
