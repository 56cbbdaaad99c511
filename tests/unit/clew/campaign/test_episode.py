"""An episode: what replays it, and what is said of one that does not end."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from msgspec.structs import replace

from clew.campaign import episode as episodes
from clew.campaign.campaign import drawn_episode
from clew.campaign.classes import by_class
from clew.campaign.episode import Episode, Surprise, play
from clew.rehearsal.rehearsal import Rehearsal
from clew.swarm.futures import Branches, branched, draw_future, read_branches
from clew.swarm.swarm import Swarm

SEED, FUTURE = 3, "3.101:r2:1"


def test_a_replay_line_quotes_a_path_with_spaces() -> None:
    episode = Episode(
        key="", path="my scenes/one.json", family="", seed=1, robots=2, robots_left_out=0, law=None,
        deployment=None, time_s_max=2.5, widest_path_radius_m=None, wall_s_max=1.0, faults="a b.toml",
    )  # fmt: skip
    assert episode.replay == (
        "./launch/clew rehearse 'my scenes/one.json' -n 2 --time-s-max 2.5 --faults 'a b.toml' --seed 1"
    )


@pytest.mark.parametrize("raised", [RuntimeError("a bug of ours"), episodes.OutOfTimeError()])
def test_a_future_that_does_not_end_is_told_of_as_this_future_with_its_faults(
    raised: BaseException, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(_: Rehearsal) -> Rehearsal:
        raise raised

    monkeypatch.setattr(Rehearsal, "run", run)
    future = replace(drawn_episode(SEED, Path(), "", wall_s_max=60.0), branches=FUTURE)
    drawn, outcome = draw_future(SEED, read_branches(FUTURE)), play(future)
    assert outcome.surprise in {Surprise.CRASHED, Surprise.STOPPED}
    assert outcome.branches == FUTURE
    assert (outcome.mode, outcome.classes) == (drawn.mode, tuple(map(str, drawn.classes)))
    figures = by_class([outcome])
    assert drawn.classes
    for each in drawn.classes:
        assert figures[each].crashed + figures[each].stopped == 1


@pytest.mark.parametrize("raised", [RuntimeError("a bug of ours"), episodes.OutOfTimeError()])
def test_a_chain_that_does_not_end_is_told_of_as_the_future_that_it_has_become(
    raised: BaseException, monkeypatch: pytest.MonkeyPatch
) -> None:
    def play_chain(_: Rehearsal, swarm: Swarm) -> Iterator[tuple[Branches, Swarm]]:
        branches = read_branches(FUTURE)
        yield branches, branched(swarm, branches)
        raise raised

    monkeypatch.setattr(episodes, "play_chain", play_chain)
    drawn = drawn_episode(SEED, Path(), "", wall_s_max=60.0)
    guided = replace(drawn, branches="", guided=True)
    assert guided.replay.endswith(f"--seeds {SEED} --guided --keep"), "its branches are not known yet"
    outcome = play(guided)
    assert outcome.surprise in {Surprise.CRASHED, Surprise.STOPPED}
    assert (outcome.branches, outcome.mode) == (FUTURE, "safety")
    assert outcome.replay == replace(drawn, branches=FUTURE).replay
