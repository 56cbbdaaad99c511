"""Searches swarm seeds in turn, with the source of its working directory. Prints one outcome a line.

`clew.guided.mutants` runs it as `python -m clew.guided.mutants_worker FIRST LAST` in a mutated copy of the
source. Each seed knows the cells of all seeds before.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

import msgspec
from msgspec.structs import replace

from clew.campaign.campaign import drawn_episode
from clew.campaign.mutants_worker import WALL_S_MAX
from clew.guided.corpus import Corpus
from clew.guided.search import Limits, search


def main(arguments: Sequence[str]) -> int:
    """Search the seeds; returns the exit code."""
    first, last = map(int, arguments)
    known = Corpus()
    for seed in range(first, last + 1):
        episode = replace(drawn_episode(seed, Path(), "", wall_s_max=WALL_S_MAX), judged=True)
        found = search(episode, known, Limits())
        known.merge(found.visits)
        sys.stdout.buffer.write(msgspec.json.encode(found.outcome) + b"\n")
        sys.stdout.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
