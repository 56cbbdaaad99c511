from functools import cache
from pathlib import Path

import pytest
from msgspec.structs import replace

from clew.campaign.campaign import drawn_episode
from clew.campaign.episode import Episode, Surprise, play
from clew.guided import search as searches
from clew.guided.corpus import Corpus
from clew.guided.search import Found, Limits, search
from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.futures import HORIZON_S, Branch, branch_at, draw_future, read_branches
from protocol.timeline import FenceChanged
from tests.support.breaking import break_at_restarts
from tests.support.deadline import DEADLINE_S
from tests.support.long import long
from world.bodies.arena import ODOMETRY_TICKS, TICK_S

SEED = 19  # three robots; its own faults start nobody again
RESTARTED = 16  # here they do
LITTLE, LEAST = Limits(roots_max=3, below_max=1), Limits(roots_max=1, below_max=0)

pytestmark = pytest.mark.usefixtures("no_child_is_left")


def episode_of(seed: int) -> Episode:
    return drawn_episode(seed, Path(), "", wall_s_max=DEADLINE_S)


@cache
def searched() -> Found:
    """A search that finds nothing, to read."""
    return search(episode_of(SEED), Corpus(), LITTLE)


def timeless(found: Found) -> Found:
    return replace(found, outcome=replace(found.outcome, cpu_s=0.0, wall_s=0.0))


@pytest.mark.long
def test_a_search_plays_futures_reaches_cells_and_is_the_same_every_time() -> None:
    found = searched()
    assert 3 <= found.outcome.futures <= 6
    assert found.outcome.cells == len(found.visits) > 10
    assert timeless(search(episode_of(SEED), Corpus(), LITTLE)) == timeless(found)


@pytest.mark.parametrize("limits", [LEAST, *long([LITTLE])])
def test_the_outcome_of_a_search_that_finds_nothing_is_that_of_the_seeds_own_faults(limits: Limits) -> None:
    own, found = play(episode_of(SEED)), search(episode_of(SEED), Corpus(), limits).outcome
    assert found.futures > 0
    assert (found.reason, found.sim_s, found.path_m) == (own.reason, own.sim_s, own.path_m)


@pytest.mark.long
def test_the_first_instants_have_futures_and_these_as_many_as_they_may() -> None:
    assert search(episode_of(SEED), Corpus(), Limits(roots_max=2, below_max=0)).outcome.futures == 2
    assert 2 < search(episode_of(SEED), Corpus(), Limits(roots_max=2, below_max=3)).outcome.futures <= 8


def test_a_run_forks_at_its_start_and_where_the_fence_has_a_new_epoch(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    forked_s: list[float] = []

    def noting(now_s: float, robot: int, future: int) -> Branch:
        forked_s.append(now_s)
        return branch_at(now_s, robot, future)

    monkeypatch.setattr(searches, "branch_at", noting)
    search(episode_of(SEED), Corpus(), Limits(roots_max=2, below_max=0))
    own = draw_future(SEED, ())
    entries = Rehearsal(own.scenario, SEED, own.plan).run().entries
    first_s = next(entry.t_s for _, entry in entries if isinstance(entry.record, FenceChanged))
    assert forked_s[0] == TICK_S
    assert first_s <= forked_s[1] <= first_s + ODOMETRY_TICKS * TICK_S


def test_the_first_future_that_surprises_ends_the_search_and_its_line_replays_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    break_at_restarts(monkeypatch)
    assert play(episode_of(SEED)).surprise is Surprise.NONE
    outcome = search(episode_of(SEED), Corpus(), Limits()).outcome
    assert outcome.surprise is Surprise.VIOLATION
    assert f"--seeds {SEED} --future {outcome.branches} --keep" in outcome.replay
    (*_, last) = read_branches(outcome.branches)
    assert last.from_s < outcome.sim_s < last.from_s + HORIZON_S + 1.0
    again = play(replace(episode_of(SEED), branches=outcome.branches))
    assert (again.surprise, again.reason, again.sim_s) == (outcome.surprise, outcome.reason, outcome.sim_s)


def test_a_seed_whose_own_faults_break_something_is_ended_there(monkeypatch: pytest.MonkeyPatch) -> None:
    break_at_restarts(monkeypatch)
    own = play(episode_of(RESTARTED))
    outcome = search(episode_of(RESTARTED), Corpus(), LITTLE).outcome
    assert (outcome.surprise, outcome.branches, outcome.futures) == (own.surprise, "", 0)
    assert outcome.sim_s < own.sim_s


def test_a_future_that_surprises_in_a_fork_only_is_a_surprise_of_its_own(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(searches, "in_a_fork", lambda _work: None)  # as if it had died
    outcome = search(episode_of(SEED), Corpus(), LITTLE).outcome
    assert outcome.surprise is Surprise.CRASHED
    assert "in a fork only" in outcome.reason
    assert outcome.branches.startswith("0.021:"), "the first instant is the start of the run"
