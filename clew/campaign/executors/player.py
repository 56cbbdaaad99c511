"""Plays episodes in a process of their own, for a worker of a cluster. A shell.

A worker runs `play_apart`; its process is this module as a program: episodes in, outcomes out, a line of JSON
each.

Rule 1: a worker runs its tasks in threads, and may neither fork nor set timers there. So each of its threads
        has one such process, which plays one episode after the other.
Rule 2: the process ends when its worker does, after the episode that it plays.
"""

import subprocess
import sys
import threading
from functools import cache
from pathlib import Path

import msgspec

from clew.campaign.campaign import hash_of_source
from clew.campaign.episode import SWARM, Episode, Outcome, play
from clew.campaign.executors.pool import lost
from protocol.errors import UsageError
from protocol.root import ROOT

_of_thread = threading.local()
_our_hash = cache(hash_of_source)


def play_apart(episode: Episode, source_hash: str) -> Outcome:
    """Play an episode in the process of this thread.

    Raises:
        UsageError: our source is not that of the campaign, or we do not have the scene's file.
    """
    if _our_hash() != source_hash:
        raise UsageError(f"a worker has another source than the campaign: {ROOT}")
    if episode.faults != SWARM and not Path(episode.path).is_file():
        raise UsageError(f"a worker has no file {episode.path}: it needs the same files at the same place")
    player = _player()
    assert player.stdin is not None, "it has a pipe"
    assert player.stdout is not None, "it has a pipe"
    try:
        player.stdin.write(msgspec.json.encode(episode) + b"\n")
        player.stdin.flush()
        line = player.stdout.readline()
    except BrokenPipeError:
        line = b""
    if not line.endswith(b"\n"):
        player.kill()
        return lost(episode)
    return msgspec.json.decode(line, type=Outcome)


def _player() -> subprocess.Popen[bytes]:
    """The process of this thread, started if there is none."""
    player: subprocess.Popen[bytes] | None = getattr(_of_thread, "player", None)
    if player is None or player.poll() is not None:
        command = [sys.executable, "-m", "clew.campaign.executors.player"]
        player = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=Path.cwd())  # noqa: S603 - our own interpreter on our own module
        _of_thread.player = player
    return player


def main() -> None:
    """Play what comes in, until there is nothing more."""
    decoder = msgspec.json.Decoder(Episode)
    for line in sys.stdin.buffer:
        sys.stdout.buffer.write(msgspec.json.encode(play(decoder.decode(line))) + b"\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
