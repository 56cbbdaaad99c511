"""The leader, middle and tail of the strand, by the timeline. Pure: entries in, answers out."""

from protocol.keys import robot_name, robot_number
from protocol.timeline import Entry, LeaderSucceeded, StepPlanned, StrandFormed


class Roles:
    """The newest strand in the timeline, and how many switching steps its leaders have planned."""

    def __init__(self) -> None:
        self.order: tuple[str, ...] = ()
        """Leader first; empty until a strand has formed."""
        self.step = 0
        self._epoch = 0

    def hear(self, source: str, entry: Entry) -> None:
        """Process an entry; entries of an older epoch are ignored."""
        match entry.record:
            case StrandFormed(epoch=epoch, order=order) if epoch >= self._epoch:
                self._epoch, self.order = epoch, tuple(map(robot_name, order))
            case LeaderSucceeded(epoch=epoch) if epoch >= self._epoch and robot_number(source):
                self._epoch = epoch
                self.order = (source, *(robot for robot in self.order if robot != source))
            case StepPlanned(step=step, joins=False) if self.order and source == self.order[0]:
                self.step = max(self.step, step)
            case _:
                pass

    def find(self, target: str, robots: int) -> tuple[str, ...]:
        """So many processes from the target towards the tail; empty while no robot has that role."""
        order = self.order
        place = {"leader": 0, "middle": len(order) // 2, "tail": len(order) - 1}.get(target)
        if place is None and target not in order:
            return (target,) if robots == 1 else ()
        first = order.index(target) if place is None else place
        return order[first : first + robots] if order else ()
