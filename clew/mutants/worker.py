"""Plays swarm episodes, seed by seed, with the source of its working directory. Prints one outcome a line.

`clew.mutants.run` runs it as `python -m clew.mutants.worker FIRST LAST [guided]` in a mutated
copy of the source.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import msgspec
from msgspec.structs import replace

from clew.campaign.campaign import drawn_episode
from clew.campaign.episode import play

WALL_S_MAX = 300.0  # as in a campaign: on a machine at load 30, an episode of 9 s of CPU took more than 60


def main(arguments: Sequence[str]) -> int:
    """Play the seeds; returns the exit code."""
    first, last, *guided = arguments
    for seed in range(int(first), int(last) + 1):
        episode = replace(drawn_episode(seed, Path(), "", wall_s_max=WALL_S_MAX), judged=True)
        outcome = play(replace(episode, branches="", guided=True) if guided else episode)
        sys.stdout.buffer.write(msgspec.json.encode(outcome) + b"\n")
        sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
