"""A register of the fence that tests talk to, and puts of robots that are called by number."""

from dataclasses import dataclass, field

from protocol.fence import Cause, Change, Epoch, Fence, May, Raise, Turn
from world.bodies.fence import Register

ROBOTS = 4
OPERATOR = 0


def life_of(robot: int, start: int = 1) -> int:
    return 100 * robot + start


def epoch(generation: int, robot: int, *, start: int = 1) -> Epoch:
    return Epoch(generation=generation, robot=robot, life=life_of(robot, start))


def raised(generation: int, robot: int, *, start: int = 1, outsider: bool = False) -> Raise:
    cause = Cause.OUTSIDERS if outsider else Cause.NEIGHBOUR_LOST
    return Raise(epoch=epoch(generation, robot, start=start), cause=cause)


def nobody(of: Epoch, turn: int) -> Turn:
    return Turn(fence=Fence(epoch=of, turn=turn))


def one(of: Epoch, turn: int, robot: int) -> Turn:
    return Turn(fence=Fence(epoch=of, turn=turn, may=May.ONE, robot=robot, life=life_of(robot)))


def all_of(of: Epoch, turn: int, *, leader: int = 1, members: int = ROBOTS) -> Turn:
    return Turn(fence=Fence(epoch=of, turn=turn, may=May.ALL, robot=leader, members=members))


@dataclass
class Talk:
    """A register that is talked to at a time that stands unless it is moved."""

    register: Register = field(default_factory=lambda: Register(ROBOTS))
    now_s: float = 0.0

    def put(self, robot: int, change: Change) -> bool:
        return self.register.put(robot, change, now_s=self.now_s) is not None

    def at(self) -> tuple[int, int, int, May]:
        """Generation, robot, turn and who may move; a method, since mypy never narrows one."""
        fence = self.register.fence
        return fence.epoch.generation, fence.epoch.robot, fence.turn, fence.may

    def formed(self, robot: int, *, members: int = ROBOTS) -> Epoch:
        """A view of this robot that comes to ALL."""
        mine = epoch(self.register.fence.epoch.generation + 1, robot)
        assert self.put(robot, Raise(epoch=mine, cause=Cause.START))
        assert self.put(robot, all_of(mine, 1, members=members))
        return mine
