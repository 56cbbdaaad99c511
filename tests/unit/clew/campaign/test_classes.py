import pytest

from clew.campaign.classes import ALL, by_class
from clew.campaign.episode import Surprise
from clew.campaign.families import ARRIVALS, figures_of, in_words, table
from clew.swarm.swarm import Mode
from tests.support.campaigns import outcome


@pytest.mark.parametrize(("episodes", "bound"), [(1, 1.0), (2, 1.0), (3, 1.0), (30, 0.1)])
def test_without_failures_the_bound_is_three_in_n_and_at_most_one(episodes: int, bound: float) -> None:
    figures = by_class([outcome(classes=("loss",), mode=Mode.LIVENESS)] * episodes)
    assert {name: (each.safety_bound, each.liveness_bound) for name, each in figures.items()} == {
        "loss": (bound, bound),
        ALL: (bound, bound),
    }


def test_a_campaign_says_in_words_which_runs_arrived_and_which_did_not_have_to() -> None:
    unasked = outcome(ok=False, mode=Mode.SAFETY)
    assert in_words([outcome()] * 5 + [unasked] * 5) == (
        "no promise broken in 10 runs; 5 arrived, 5 did not have to"
    )
    broken = outcome(ok=False, violations=2, surprise=Surprise.VIOLATION, mode=Mode.SAFETY)
    lost = outcome(ok=False, no_route=True)
    assert in_words([]) == "no promise broken in 0 runs"
    assert in_words([broken, lost]) == "promises broken in 1 of 2 runs; 1 found no way, 1 failed"
    assert in_words([outcome()]) == "no promise broken in 1 run; 1 arrived"


def test_the_table_and_the_last_line_count_each_fleet_once_and_alike() -> None:
    killed = outcome(
        robots_arrived=3, mode=Mode.SAFETY
    )  # two of five robots are dead, and the others have arrived
    unasked = outcome(ok=False, mode=Mode.SAFETY)
    figures = figures_of([killed, killed, unasked])
    assert [getattr(figures, field) for field in ARRIVALS] == [2, 0, 1, 0]
    assert in_words([killed, killed, unasked]).endswith("; 2 arrived, 1 did not have to")
    assert figures.solvable is None
    cells = {str(column.header): next(iter(column.cells)) for column in table({}, figures).columns}
    assert [cells[title] for title in ("arrived", "no way", "not\nasked", "failed", "solvable")] == [
        *"2010",
        "-",
    ]
