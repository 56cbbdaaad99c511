"""What has to be known of a log before it can be written in the order of its times.

Rule 1: entries come in the order of their times; those of one time as they stand in the log.
"""

import math
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import islice

import numpy as np

from clew.log.log import Log
from clew.story.strands import Strands
from protocol.arrays import Floats
from protocol.path import Path
from protocol.timeline import Entry
from world.record.lines import Line


@dataclass(frozen=True, slots=True)
class Survey:
    """A log that has been gone through once."""

    log: Log
    coming_s: Floats
    """The least time of each entry and of all behind it in the log."""
    paths: dict[int, Path]
    """The strand's path in each epoch, whole."""

    def lines(self) -> Iterator[Line]:
        """The entries in order; of one late in the log, all that it comes before are held until then."""
        held: list[tuple[float, int, str, Entry]] = []
        behind_s = [*self.coming_s[1:].tolist(), math.inf]
        for place, (source, entry) in enumerate(islice(self.log.lines, len(behind_s))):
            heappush(held, (entry.t_s, place, source, entry))
            while held and held[0][0] <= behind_s[place]:
                _, _, source, entry = heappop(held)  # noqa: PLW2901 - the line to give is another one
                yield source, entry


def survey(log: Log) -> Survey:
    """Go through a log."""
    times_s, strands = array("d"), Strands()
    for source, entry in log.lines:
        times_s.append(entry.t_s)
        strands.hear(source, entry)
    coming_s = np.minimum.accumulate(np.array(times_s)[::-1])[::-1]
    return Survey(log, coming_s, strands.paths())
