"""The fence, bodies and robots of the model. NamedTuples, because a search hashes millions of them."""

from enum import StrEnum
from typing import NamedTuple

# In the epochs that the register takes of its own. Robots count from 0 here; in the design from 1.
REGISTER_NUMBER = -1


class Epoch(NamedTuple):
    """Numbers the views: compared by generation, then by the proposer's number."""

    generation: int
    robot: int
    life: int


class OrderNumber(NamedTuple):
    """A later life's orders are beyond all of the earlier."""

    life: int
    nth: int


class Named(NamedTuple):
    """One life of one robot."""

    robot: int
    life: int


class May(StrEnum):
    """Which robots may move by a fence, where it is not one robot."""

    NOBODY = "nobody"
    ALL = "all"
    STOPPED = "stopped"
    ANY = "any"  # every robot has a turn at once: only where ONE_NAMED is left out


class Fence(NamedTuple):
    """What bodies obey. `fence[:2]` is what an order has to bear."""

    epoch: Epoch
    turn: int = 0
    who: May | Named = May.NOBODY


class Kind(StrEnum):
    """By what a robot drives."""

    LEASE = "lease"
    STRAND = "strand"


class Quality(StrEnum):
    """What the judge knows of a scan, and the robot does not."""

    NONE = "none"  # a follower drives by authority, on no scan
    CLEAN = "clean"
    DIRTY = "dirty"  # another body moved when it was taken
    STALE = "stale"  # another body has moved since


class Motion(NamedTuple):
    """What a body drives by. `ground`: whose plan a strand step follows (the life that planned it)."""

    fence: Fence
    kind: Kind
    number: OrderNumber
    braking: bool
    ground: int | None


class Body(NamedTuple):
    """A hull. `place` is a version that grows with each motion. `ground`: what its strand step drove."""

    place: int = 0
    motion: Motion | None = None
    newest: OrderNumber = OrderNumber(0, 0)
    ended: OrderNumber = OrderNumber(0, 0)
    ground: int | None = None


class Reading(NamedTuple):
    """What an odometry tells beside the fence. Under one fence the greater reading is the newer."""

    place: int
    moving: bool
    ended: OrderNumber
    in_force: bool


AT_REST = Reading(0, moving=False, ended=OrderNumber(0, 0), in_force=True)


class Scan(NamedTuple):
    """What a robot saw, with the fence that the scan bears."""

    epoch: Epoch
    turn: int
    in_force: bool
    quality: Quality


class Place(NamedTuple):
    """Where a formation says that one life of a robot stands."""

    robot: int
    place: int
    life: int


class Formation(NamedTuple):
    """What a view agrees on; `turn` is that of its all. `places` are in the strand's order, leader first."""

    epoch: Epoch
    turn: int
    places: tuple[Place, ...]

    def beside(self, robot: int, step: int) -> Place | None:
        """The member ahead (step -1) or behind (step 1)."""
        at = [member.robot for member in self.places].index(robot) + step
        return self.places[at] if 0 <= at < len(self.places) else None


class Reported(NamedTuple):
    """What a coordinator knows of one robot; `turn` is that of the odometry that told it."""

    place: int
    life: int
    turn: int


class Mode(StrEnum):
    """The four states of a robot, design 4.4."""

    BOUND = "bound"
    JOINING = "joining"
    MEMBER = "member"
    ASIDE = "aside"


class Robot(NamedTuple):
    """One life of one robot's process."""

    life: int = 0
    know: Fence | None = None  # the newest that odometry told
    reading: Reading | None = None
    mode: Mode = Mode.BOUND
    done: int = 0  # the own turn that it has said to be over
    ordered: int = 0  # orders sent
    pending: OrderNumber | None = None  # the order that has not ended yet
    scan: Scan | None = None
    form: Formation | None = None
    path: int | None = None  # the plan that it follows: the life that planned it
    authority: bool = False
    sent: bool = False  # its one strand step is ordered
    # Of a coordinator: what each robot reported, the last turn put for each (0: none), the last turn put.
    reports: tuple[Reported | None, ...] | None = None
    gave: tuple[int, ...] | None = None
    put: int = 0
