import pytest

from clew.campaign.classes import ALL, by_class
from clew.swarm.swarm import Mode
from tests.support.campaigns import outcome


@pytest.mark.parametrize(("episodes", "bound"), [(1, 1.0), (2, 1.0), (3, 1.0), (30, 0.1)])
def test_without_failures_the_bound_is_three_in_n_and_at_most_one(episodes: int, bound: float) -> None:
    figures = by_class([outcome(classes=("loss",), mode=Mode.LIVENESS)] * episodes)
    assert {name: (each.safety_bound, each.liveness_bound) for name, each in figures.items()} == {
        "loss": (bound, bound),
        ALL: (bound, bound),
    }
