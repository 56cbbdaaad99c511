import os
from pathlib import Path

import pytest
from msgspec.structs import replace

from clew.campaign import episode as episodes
from clew.campaign.campaign import drawn_episode
from clew.campaign.episode import Episode, Outcome, Stage, Surprise, play
from clew.guided import runner
from clew.guided.corpus import Corpus
from clew.guided.runner import Limits
from clew.guided.search import Found, search
from clew.rehearsal.rehearsal import Rehearsal
from world.judge.verdict import Verdict

SEED = 16  # in safety mode, ends early, and its own faults kill nobody
LITTLE = Limits(sim_s_max=20.0, horizon_s=3.0, slots=6)


def episode_of(seed: int) -> Episode:
    return drawn_episode(seed, Path(), "", wall_s_max=60.0)


def timeless(found: Found) -> Found:
    return replace(found, outcome=replace(found.outcome, cpu_s=0.0, wall_s=0.0))


def losses_surprise(verdict: Verdict, *, expected: int, **_: object) -> Surprise:
    return Surprise.VIOLATION if expected < verdict.robots else Surprise.NONE


def test_a_search_plays_futures_reaches_cells_and_is_the_same_every_time() -> None:
    found = search(episode_of(SEED), Corpus(), LITTLE)
    assert found.outcome.futures > 3
    assert found.outcome.cells == len(found.visits) > 50
    assert timeless(search(episode_of(SEED), Corpus(), LITTLE)) == timeless(found)


def test_where_nothing_is_new_only_the_seeds_own_faults_are_played() -> None:
    first = search(episode_of(SEED), Corpus(), LITTLE)
    again = search(episode_of(SEED), Corpus(first.visits), LITTLE)
    assert (again.outcome.futures, again.outcome.cells) == (0, 0)
    assert again.outcome.sim_s == play(episode_of(SEED)).sim_s


def test_a_search_leaves_no_process() -> None:
    search(episode_of(SEED), Corpus(), LITTLE)
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)


def test_the_first_future_that_surprises_ends_the_search_and_its_line_replays_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(episodes, "surprise_of", losses_surprise)
    assert play(episode_of(SEED)).surprise is Surprise.NONE
    outcome = search(episode_of(SEED), Corpus(), replace(LITTLE, sim_s_max=60.0)).outcome
    assert outcome.surprise is Surprise.VIOLATION
    assert f"--seeds {SEED} --future {outcome.branches} --keep" in outcome.replay
    again = play(replace(episode_of(SEED), branches=outcome.branches))
    assert (again.surprise, again.reason, again.sim_s) == (outcome.surprise, outcome.reason, outcome.sim_s)


def test_a_future_that_surprises_only_because_it_was_cut_off_is_no_surprise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = episodes.outcome_of

    def cut_off(episode: Episode, stage: Stage, *rest: Rehearsal, wall_s: float) -> Outcome:
        outcome = real(episode, stage, *rest, wall_s=wall_s)
        return replace(outcome, surprise=Surprise.VIOLATION) if episode.branches else outcome

    monkeypatch.setattr(runner, "outcome_of", cut_off)
    outcome = search(episode_of(SEED), Corpus(), LITTLE).outcome
    assert outcome.surprise is Surprise.NONE
    assert outcome.futures > 3


def test_a_search_whose_process_dies_says_so_and_leaves_none(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "look", lambda _rehearsal: os._exit(3))
    monkeypatch.setattr("clew.guided.search.LATE_S", -59.0)  # so it waits for a second
    assert search(episode_of(SEED), Corpus(), LITTLE).outcome.surprise is Surprise.CRASHED
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)
