"""One moment of the model, and what may come next."""

from collections.abc import Iterator
from typing import NamedTuple, TypeVar

from tests.model.messages import Message
from tests.model.values import Body, Fence, Formation, Robot

T = TypeVar("T")


class State(NamedTuple):
    """One moment. The counts are of what may still happen, so that a search ends."""

    fence: Fence
    bodies: tuple[Body, ...]
    robots: tuple[Robot, ...]
    net: frozenset[Message]
    raises: int
    faults: int
    late: int
    stops: int
    acted: Formation | None = None  # the judge's: the formation that has moved a body in this epoch
    disk: Fence | None = None  # an older fence, where WRITTEN_FIRST is left out
    halted: bool = False  # the judge's: the operator's last word is stop

    def with_robot(self, i: int, robot: Robot, *sent: Message) -> "State":
        """Robot `i` has changed and sent messages."""
        return self._replace(robots=put(self.robots, i, robot), net=self.net.union(sent))

    def with_body(self, i: int, body: Body) -> "State":
        """Body `i` has changed."""
        return self._replace(bodies=put(self.bodies, i, body))

    def heard(self, message: Message) -> "State":
        """A message has arrived for good: heard again it would change nothing."""
        return self._replace(net=self.net - {message})

    @property
    def in_force(self) -> bool:
        """Has every body come to stand under the fence, or moves by it?"""
        return not any(body.motion and body.motion.braking for body in self.bodies)


def put(seq: tuple[T, ...], i: int, value: T) -> tuple[T, ...]:
    """The tuple with one value replaced."""
    return (*seq[:i], value, *seq[i + 1 :])


Steps = Iterator[tuple[str, State | None]]  # what happens, and what comes of it; None where nothing changes
