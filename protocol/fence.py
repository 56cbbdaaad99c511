"""The fence: the one epoch and turn whose orders bodies obey, and who may move by them; docs/strand.md.

Rule 1: fences are ordered by generation, robot and turn. They only ever go forward.
Rule 2: a body obeys an order that bears exactly its fence, from a robot that the fence names; `obeys` is the
        one place that says so.
Rule 3: a fence comes into force when every body of the fleet has taken it and stands. All bodies of a fleet
        are in one process, so that is at once.
"""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta, Struct

from protocol.frames import ROBOTS_MAX, Count, RobotCount

NUMBERS = 10_000  # of robots per generation: five times `ROBOTS_MAX`; a power of ten keeps epochs readable
GENERATIONS_MAX = 2**39  # so that an epoch's number is a `Count`
NOBODY_NUMBER = 0  # of no robot: the operator, and a world that has been started again

LIFE_BITS = 63  # of chance: two processes of a fleet never draw the same
Life = Annotated[int, Meta(ge=0, le=2**LIFE_BITS - 1, description="random bits of a process; 0: of no robot")]
AnyRobot = Annotated[int, Meta(ge=0, le=ROBOTS_MAX, description="0: no robot")]


class Epoch(Struct, frozen=True, gc=False, kw_only=True):
    """The number of a view: its generation, and the robot that proposed it, in that life."""

    generation: Annotated[int, Meta(ge=0, le=GENERATIONS_MAX)] = 0
    robot: AnyRobot = NOBODY_NUMBER
    life: Life = 0

    @property
    def number(self) -> int:
        """The epoch as one number, as in the timeline: in force, two epochs never have the same."""
        return self.generation * NUMBERS + self.robot

    def next(self, robot: int, life: int) -> "Epoch":
        """The epoch that this life of a robot may propose after this one."""
        return Epoch(generation=self.generation + 1, robot=robot, life=life)


class May(StrEnum):
    """Which robots may move under a fence."""

    NOBODY = "nobody"
    ONE = "one"  # a turn lease
    ALL = "all"
    STOPPED = "stopped"  # nobody, and no view may be proposed until the operator releases it


class Fence(Struct, frozen=True, gc=False, kw_only=True):
    """What every body of the fleet obeys at one moment."""

    epoch: Epoch = Epoch()
    turn: Count = 0
    may: May = May.NOBODY
    robot: AnyRobot = NOBODY_NUMBER
    """ONE: who may move; ALL: who leads the strand."""
    life: Life = 0
    """ONE: the life of that robot."""
    members: RobotCount = 0
    """ALL: how many robots are in the strand."""

    @property
    def key(self) -> tuple[int, int, int]:
        """Rule 1."""
        return self.epoch.generation, self.epoch.robot, self.turn

    def names(self, robot: int, life: int) -> bool:
        """Whether this life of a robot may move under the fence."""
        one = self.may is May.ONE and (self.robot, self.life) == (robot, life)
        return one or self.may is May.ALL


class Bearing(Struct, frozen=True, gc=False, kw_only=True):
    """What an order to drive bears: the fence under which it was given, and the life that gave it."""

    epoch: Epoch = Epoch()
    turn: Count = 0
    life: Life = 0


def obeys(fence: Fence, robot: int, bearing: Bearing) -> bool:
    """Rule 2."""
    exactly = (bearing.epoch, bearing.turn) == (fence.epoch, fence.turn)
    return exactly and fence.names(robot, bearing.life)


class Cause(StrEnum):
    """Why a view was proposed."""

    START = "start"
    NEIGHBOUR_LOST = "neighbour_lost"
    BLOCKED = "blocked"  # the strand dissolves: no places are kept
    DEAD_END = "dead_end"  # the strand turns round
    NO_WAY = "no_way"  # the leader knows no way on, and another might
    PLEA = "plea"  # a robot that is left out asks to be let in
    COORDINATOR_LOST = "coordinator_lost"
    MISFIT = "misfit"  # a member does not stand where the formation has it
    OUTSIDERS = "outsiders"  # put by a robot that is left out: over ALL it counts when enough ask
    OPERATOR = "operator"  # a stop, or its release
    WORLD_RESTARTED = "world_restarted"


class Raise(Struct, frozen=True, gc=False, kw_only=True, tag="raise"):
    """Put by any robot: the next generation, in which nobody may move yet."""

    epoch: Epoch
    cause: Cause


class Turn(Struct, frozen=True, gc=False, kw_only=True, tag="turn"):
    """Put by the coordinator: the next turn of its epoch."""

    fence: Fence


class Stop(Struct, frozen=True, gc=False, kw_only=True, tag="stop"):
    """Put by the operator: nobody may move until the release."""


class Release(Struct, frozen=True, gc=False, kw_only=True, tag="release"):
    """Put by the operator: ends the stop of this generation, and of no other."""

    generation: Count


Change = Raise | Turn | Stop | Release
"""All that is put on `body/fence/{robot}`."""


def in_force(fence: Fence) -> bool:
    """Whether every body of the fleet has taken the fence, and stands or moves by it (rule 3)."""
    del fence  # bodies on computers of their own will each acknowledge it
    return True
