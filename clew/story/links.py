"""How the links of the strand are, as changes through time. Pure.

Rule 1: a link is as the worse of its two ends saw it: broken, silent, up.
Rule 2: where a strand comes into force, all of its links are up.
Rule 3: robots' entries may come after later ones of others; changes of one link never go back in time.
"""

from dataclasses import dataclass, field
from enum import StrEnum
from itertools import pairwise

from clew.story import forming
from clew.story.forming import Forming
from protocol.keys import robot_number
from protocol.timeline import Entry, LinkBroken, LinkHeard, LinkSilent

KINDS = frozenset({LinkBroken, LinkHeard, LinkSilent}) | forming.KINDS


class LinkState(StrEnum):
    """The worse, the later."""

    UP = "up"
    SILENT = "silent"
    BROKEN = "broken"


@dataclass(frozen=True, slots=True)
class LinkChange:
    """A link is in this state from a time on; the lower of its two robots first."""

    t_s: float
    one: int
    other: int
    state: LinkState


@dataclass(slots=True)
class Links:
    """All links, and how their states have changed."""

    changes: list[LinkChange] = field(default_factory=list)
    """In the order in which they were heard of."""
    _ends: dict[tuple[int, int], LinkState] = field(default_factory=dict)
    """How a robot sees its link to a neighbour."""
    _newest: dict[tuple[int, int], LinkChange] = field(default_factory=dict)
    _forming: Forming = field(default_factory=Forming)

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        if (strand := self._forming.hear(entry)) is not None:
            for ahead, behind in pairwise(strand.formed.order):
                self._see(strand.t_s, ahead, behind, LinkState.UP)
                self._see(strand.t_s, behind, ahead, LinkState.UP)
        elif (robot := robot_number(source)) is not None and (seen := _seen(entry)) is not None:
            self._see(entry.t_s, robot, *seen)

    def _see(self, t_s: float, robot: int, neighbour: int, state: LinkState) -> None:
        self._ends[robot, neighbour] = state
        one, other = sorted((robot, neighbour))
        ends = {state, self._ends.get((neighbour, robot), LinkState.UP)}
        worse = [each for each in LinkState if each in ends][-1]
        before = self._newest.get((one, other))
        if before is None or before.state is not worse:
            at_s = t_s if before is None else max(t_s, before.t_s)
            change = self._newest[one, other] = LinkChange(at_s, one, other, worse)
            self.changes.append(change)


def _seen(entry: Entry) -> tuple[int, LinkState] | None:
    """Of which neighbour a robot says something."""
    match entry.record:
        case LinkSilent(neighbour=neighbour):
            return neighbour, LinkState.SILENT
        case LinkBroken(neighbour=neighbour):
            return neighbour, LinkState.BROKEN
        case LinkHeard(neighbour=neighbour):
            return neighbour, LinkState.UP
        case _:
            return None  # nothing of a link
