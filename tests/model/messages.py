"""What is sent. A message stays in the net and may arrive late, often, out of order or never.

Tuples of equal content are equal whatever their kind: no two kinds have both the same length and types,
where bool counts as int (`test_model.py` checks it).
"""

from typing import NamedTuple

from tests.model.values import Epoch, Fence, Formation, Kind, OrderNumber, Quality, Reading, Reported


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
