"""Plays the episodes of a swarm, seed by seed, in the tree that it is started in: one outcome a line.

`python -m clew.campaign.mutants_hunt FIRST LAST`, for `clew.campaign.mutants`, which starts it in a tree with
a bug in it.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import msgspec

from clew.campaign.campaign import drawn_episode
from clew.campaign.episode import play

WALL_S_MAX = 60.0  # an episode takes a third of a second: one that takes so long has no end


def main(arguments: Sequence[str]) -> int:
    """Play the seeds; returns the exit code."""
    first, last = map(int, arguments)
    for seed in range(first, last + 1):
        outcome = play(drawn_episode(seed, Path(), "", wall_s_max=WALL_S_MAX))
        sys.stdout.buffer.write(msgspec.json.encode(outcome) + b"\n")
        sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
