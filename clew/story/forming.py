"""When a strand comes into force: its formation is made before, and the fence lets all of it drive. Pure.

Rule 1: entries of the coordinator and of the world come in any order; a strand is told of once, when both are
        known, from the time of the fence on.
"""

from dataclasses import dataclass, field

from protocol.fence import May
from protocol.timeline import Entry, FenceChanged, StrandFormed

KINDS = frozenset({FenceChanged, StrandFormed})


@dataclass(frozen=True, slots=True)
class Strand:
    """The strand of an epoch, in force from a time on."""

    t_s: float
    formed: StrandFormed


@dataclass(slots=True)
class Forming:
    """Formations and fences, until they meet."""

    _formed: dict[int, StrandFormed] = field(default_factory=dict)
    _since_s: dict[int, float] = field(default_factory=dict)
    """When the fence named all, by epoch."""
    _told: set[int] = field(default_factory=set)

    def hear(self, entry: Entry) -> Strand | None:
        """The strand that an entry brings into force."""
        match entry.record:
            case StrandFormed(epoch=epoch) as formed:
                self._formed.setdefault(epoch, formed)
            case FenceChanged(epoch=epoch, may=May.ALL):
                self._since_s.setdefault(epoch, entry.t_s)
            case _:
                return None
        if epoch in self._told or epoch not in self._formed or epoch not in self._since_s:
            return None
        self._told.add(epoch)
        return Strand(self._since_s[epoch], self._formed[epoch])
