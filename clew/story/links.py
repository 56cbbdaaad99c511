"""How the links of the strand are, as changes through time. Pure.

Rule 1: a link is as the worse of its two ends saw it: broken, silent, up.
Rule 2: robots' entries may come after later ones of others; changes of one link never go back in time.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum

from protocol.keys import robot_number
from protocol.timeline import Entry, LinkBroken, LinkHeard, LinkSilent, StrandFormed

KINDS = frozenset({LinkBroken, LinkHeard, LinkSilent, StrandFormed})


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

    def hear(self, source: str, entry: Entry) -> None:
        """Take an entry in."""
        robot = robot_number(source)
        for neighbour, state in () if robot is None else _seen(robot, entry):
            assert robot is not None
            self._ends[robot, neighbour] = state
            one, other = sorted((robot, neighbour))
            ends = {state, self._ends.get((neighbour, robot), LinkState.UP)}
            worse = [each for each in LinkState if each in ends][-1]
            before = self._newest.get((one, other))
            if before is None or before.state is not worse:
                at_s = entry.t_s if before is None else max(entry.t_s, before.t_s)
                change = self._newest[one, other] = LinkChange(at_s, one, other, worse)
                self.changes.append(change)


def _seen(robot: int, entry: Entry) -> Iterator[tuple[int, LinkState]]:
    """Which links a robot says something of."""
    match entry.record:
        case LinkSilent(neighbour=neighbour):
            yield neighbour, LinkState.SILENT
        case LinkBroken(neighbour=neighbour):
            yield neighbour, LinkState.BROKEN
        case LinkHeard(neighbour=neighbour):
            yield neighbour, LinkState.UP
        case StrandFormed(order=order) if robot in order:
            place = order.index(robot)
            for neighbour in (*order[max(place - 1, 0) : place], *order[place + 1 : place + 2]):
                yield neighbour, LinkState.UP
        case _:
            pass  # nothing of a link
