"""The leader, middle and tail of the strand, and who coordinates, by the timeline. Pure.

Rule 1: entries of an older epoch are ignored.
Rule 2: the world reads all entries, a robot only its own. So `strand.formed`, which the coordinator writes,
        tells the whole order, and `strand.joined` tells each member its own place in it.
"""

from protocol.fence import NUMBERS
from protocol.keys import robot_name, robot_number
from protocol.timeline import Entry, StepPlanned, StrandFormed, StrandJoined, ViewJoined

UNKNOWN = ""


class Roles:
    """The newest strand and view in the timeline, and how many switching steps leaders have planned."""

    def __init__(self) -> None:
        self.order: tuple[str, ...] = ()
        """Leader first; empty until a strand has formed, and `UNKNOWN` where a robot knows only itself."""
        self.coordinator = UNKNOWN
        self.step = 0
        self._formed = self._joined = 0  # by the epoch's number

    def hear(self, source: str, entry: Entry) -> None:
        """Process an entry."""
        match entry.record:
            case ViewJoined(epoch=epoch) if epoch >= self._joined and robot_number(source):
                proposer = epoch % NUMBERS  # 0: nobody coordinates it
                self._joined, self.coordinator = epoch, robot_name(proposer) if proposer else UNKNOWN
            case StrandFormed(epoch=epoch, order=order) if epoch >= self._formed:
                self._formed, self.order = epoch, tuple(map(robot_name, order))
            case StrandJoined(epoch=epoch, rank=rank, members=members) if epoch > self._formed:
                behind = (UNKNOWN,) * max(0, members - rank - 1)
                self._formed, self.order = epoch, ((UNKNOWN,) * rank + (source, *behind))
            case StepPlanned(step=step, joins=False) if self.order and source == self.order[0]:
                self.step = max(self.step, step)
            case _:
                pass

    def find(self, target: str, robots: int) -> tuple[str, ...]:
        """So many processes from the target towards the tail; empty while no robot has that role."""
        if target == "coordinator":
            target = self.coordinator
        order = self.order
        place = {"leader": 0, "middle": len(order) // 2, "tail": len(order) - 1}.get(target)
        if place is None and target not in order:
            return (target,) if robots == 1 and target != UNKNOWN else ()
        first = order.index(target) if place is None else place
        found = order[first : first + robots] if order else ()
        return () if UNKNOWN in found else found
