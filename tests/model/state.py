"""What is sent, and one moment of the model. A message stays in the net and may arrive late, often or never.

Tuples of equal content are equal whatever their kind: no two kinds of message have both the same length and
the same types, where bool counts as int (`test_model.py` checks it).
"""

from collections.abc import Iterator
from typing import NamedTuple, TypeVar

from tests.model.values import (
    Body,
    Epoch,
    Fence,
    Formation,
    Kind,
    OrderNumber,
    Quality,
    Reading,
    Reported,
    Robot,
)

T = TypeVar("T")


class Raise(NamedTuple):
    """To the register: a new epoch."""

    epoch: Epoch


class Turn(NamedTuple):
    """To the register, by the coordinator: the next turn."""

    fence: Fence


class Release(NamedTuple):
    """To the register, by the operator: the end of the stop that took this generation."""

    generation: int
    operator: str = "operator"


class Stand(NamedTuple):
    """To a body: stand, numbered beyond all earlier lives' orders."""

    robot: int
    life: int


class Order(NamedTuple):
    """To a body: drive. `form` is for the judge, `quality` is that of the scan that it rests on."""

    robot: int
    fence: Fence
    kind: Kind
    number: OrderNumber
    form: Formation | None
    quality: Quality
    ground: int | None


class Odometry(NamedTuple):
    """To a robot, late; odometry in time is told without a message."""

    to: int
    fence: Fence
    reading: Reading


class Report(NamedTuple):
    """To the coordinator."""

    to: int
    epoch: Epoch
    robot: int
    said: Reported


class FormationTold(NamedTuple):
    """To a member."""

    to: int
    epoch: Epoch
    form: Formation


class PathTold(NamedTuple):
    """To the member behind: whose plan the robot ahead follows."""

    to: int
    epoch: Epoch
    life: int
    planner: int | None


class Grant(NamedTuple):
    """To the member behind: authority over the ground that the robot ahead has left."""

    to: int
    epoch: Epoch
    life: int


ToRobot = Report | FormationTold | PathTold | Grant
Message = Raise | Turn | Release | Stand | Order | Odometry | ToRobot


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
