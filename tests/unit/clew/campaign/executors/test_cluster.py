"""Campaigns on a Dask cluster: as on local processes, though workers die."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from distributed import Client, LocalCluster
from msgspec.structs import replace

from clew.campaign.campaign import drawn_episode, hash_of_source
from clew.campaign.episode import CRASHED, Episode, Outcome, Surprise, play
from clew.campaign.executors import player
from clew.campaign.executors.cluster import cluster_outcomes
from clew.campaign.executors.player import play_apart
from protocol.errors import UsageError
from tests.support.campaigns import clew, scene, told
from tests.support.deadline import DEADLINE_S

OF_THE_MACHINE = ("wall_s", "cpu_s")


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    """A scheduler on loopback and two workers; who dies is started again."""
    page = "127.0.0.1:0"  # Dask's own takes port 8787, which another cluster here may have
    with (
        pytest.MonkeyPatch.context() as patient,
        LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=page) as started,
    ):
        patient.setattr("clew.campaign.executors.cluster.PATIENCE_S", DEADLINE_S)
        yield started


def campaign(scenes: Path, out: Path, *more: str) -> dict[str, Any]:
    """Play three scenes with two seeds, and one robot each; returns the outcomes by key."""
    said = clew("campaign", "--scenes", scenes, "--robots", "1", "--seeds", "1-2", "--out", out, *more)
    assert said.exit_code == 0, said.output
    lines = [json.loads(line) for line in (out / "episodes.jsonl").read_text().splitlines()]
    outcomes = {line["key"]: {k: v for k, v in line.items() if k not in OF_THE_MACHINE} for line in lines}
    assert len(outcomes) == len(lines) == 6, "no episode is lost, and none counts twice"
    return outcomes


def test_a_campaign_on_a_cluster_of_which_a_worker_is_killed_has_the_outcomes_of_one_on_this_machine(
    cluster: LocalCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for number in range(3):
        scene(tmp_path / "scenes" / f"{number}.json", circles=[[3.0, 0.6, 0.1 + 0.05 * number]])
    killed: list[int] = []

    def killing(episodes: Sequence[Episode], jobs: int, **of_cluster: str) -> Iterator[Outcome]:
        for outcome in cluster_outcomes(episodes, jobs, **of_cluster):
            if not killed:
                with Client(cluster.scheduler_address, set_as_default=False) as client:
                    killed.append(min(client.run(os.getpid).values()))
                os.kill(killed[-1], signal.SIGKILL)
            yield outcome

    monkeypatch.setattr("clew.campaign.executors.cluster.cluster_outcomes", killing)
    on_cluster = ("--executor", "dask", "--scheduler", cluster.scheduler_address)
    there = campaign(tmp_path / "scenes", tmp_path / "there", *on_cluster)
    assert there == campaign(tmp_path / "scenes", tmp_path / "here", "--jobs", "1")
    assert killed


def test_a_guided_campaign_on_a_cluster_has_the_outcomes_of_one_on_this_machine(
    cluster: LocalCluster, tmp_path: Path
) -> None:
    for out, *where in (
        ("there", "--executor", "dask", "--scheduler", cluster.scheduler_address),
        ("here", "--jobs", "1"),
    ):
        guided = ("--faults", "swarm", "--guided", "--seeds", "19-20", "--out", tmp_path / out)
        assert clew("campaign", *guided, *where).exit_code == 0
    here, there = (
        [each | dict.fromkeys(OF_THE_MACHINE) for each in told(tmp_path / out)["episodes"]]
        for out in ("here", "there")
    )
    assert here == there
    assert all(each["branches"] for each in here), "each seed is struck"


def test_a_worker_with_another_source_or_without_the_scene_refuses(
    cluster: LocalCluster, tmp_path: Path
) -> None:
    drawn, ours = drawn_episode(1, tmp_path, "", wall_s_max=DEADLINE_S), hash_of_source()
    of_file = replace(drawn, faults=None, path=str(tmp_path / "gone.json"))
    for episode, source_hash, reason in ((drawn, "ab", "another source"), (of_file, ours, "has no file")):
        with pytest.raises(UsageError, match=reason):
            list(cluster_outcomes([episode], 1, scheduler=cluster.scheduler_address, source_hash=source_hash))


REFUSED: dict[str, tuple[tuple[str, ...], str]] = {
    "no address": (("--executor", "dask"), "needs --scheduler"),
    "no Dask": (("--scheduler", "tcp://127.0.0.1:1"), "needs --executor dask"),
    "jobs": (("--executor", "dask", "--scheduler", "tcp://127.0.0.1:1", "--jobs", "2"), "--jobs must not"),
    "no scheduler": (("--executor", "dask", "--scheduler", "tcp://127.0.0.1:1"), "no Dask scheduler answers"),
    "no such protocol": (("--executor", "dask", "--scheduler", "abc://x:1"), "no Dask scheduler answers"),
}


@pytest.mark.parametrize(("options", "reason"), REFUSED.values(), ids=REFUSED.keys())
def test_what_is_no_cluster_is_refused_in_one_line(
    options: tuple[str, ...], reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("clew.campaign.executors.cluster.PATIENCE_S", 0.2)
    said = clew("campaign", "--scenes", scene(tmp_path / "one.json"), "--out", tmp_path / "out", *options)
    assert said.exit_code == 2
    assert reason in said.output.splitlines()[-1]


def test_an_episode_whose_player_dies_has_an_outcome_and_the_next_one_is_played(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn, ours = drawn_episode(1, tmp_path, "", wall_s_max=DEADLINE_S), hash_of_source()
    episode = replace(drawn, faults=None, path=str(scene(tmp_path / "one.json")), robots=1)  # it is short
    dies = [sys.executable, "-c", "input()"]
    with subprocess.Popen(dies, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as dying:
        monkeypatch.setattr(player, "_player", lambda: dying)
        outcome = play_apart(episode, ours)
    assert (outcome.surprise, outcome.ending) == (Surprise.CRASHED, CRASHED)
    monkeypatch.undo()
    with player._player():
        played = play_apart(episode, ours)
    assert played.reason == play(episode).reason
