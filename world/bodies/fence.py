"""The register of the fence: what every body of the fleet obeys, and which puts change it; docs/strand.md.

It decides nothing for the robots: it is a register, as a body's own controller would be.

Rule 1: a fence only goes forward, and one number of a turn has one content.
Rule 2: a raise takes the next generation, at turn 0, where nobody may move. At turn 0 one of the same
        generation with a higher number replaces it. Over STOPPED none is taken.
Rule 3: a turn is the next turn of the epoch in force, from the robot that proposed it, in that same life.
        There is none after ALL.
Rule 4: the operator, who has number 0, stops the fleet and releases it; each takes the next generation. A
        release ends the stop of the generation that it names.
Rule 5: a world that has been started again takes the next generation, number 0. A stop stays in force.
Rule 6: a put counts only under the number of its key.
Rule 7: over ALL, raises of robots that are not in the strand are held. One is taken when more such robots
        than the strand has members have asked within `OUTSIDERS_S`.
Rule 8: a robot that has no raise left raises nothing (`world.quota`).

Rules 1 to 6 are for safety, 7 and 8 for liveness.
"""

from dataclasses import dataclass
from typing import assert_never

from protocol.fence import (
    NOBODY_NUMBER,
    Cause,
    Change,
    Epoch,
    Fence,
    May,
    Raise,
    Release,
    Stop,
    Turn,
)
from protocol.timeline import FenceChanged
from world.quota import Quotas

OUTSIDERS_S = 5.0  # simulated; a robot repeats its raise many times a second


@dataclass(frozen=True, slots=True)
class Taken:
    """A change of the fence."""

    fence: Fence
    cause: Cause | None = None
    """Why its epoch was proposed; None: it is a turn."""

    def as_record(self) -> FenceChanged:
        """The change as an entry of the timeline."""
        fence = self.fence
        return FenceChanged(
            epoch=fence.epoch.number,
            turn=fence.turn,
            may=fence.may,
            coordinator=fence.epoch.robot,
            life=f"{fence.epoch.life:x}" if fence.epoch.life else "",
            named=fence.robot,
            named_life=f"{fence.life:x}" if fence.may is May.ONE else "",
            members=fence.members,
            cause=self.cause,
        )


class Register:
    """The fence of a fleet of robots 1 to `robots`."""

    def __init__(self, robots: int, fence: Fence | None = None, quotas: Quotas | None = None) -> None:
        """A register that goes on begins with the fence and the quotas of the one before."""
        self.fence = Fence() if fence is None else fence
        self._robots = range(1, robots + 1)
        self._quotas = Quotas() if quotas is None else quotas
        self._asked_s: dict[int, float] = {}
        """When each outsider last asked for a raise over the present ALL."""

    def put(self, robot: int, change: Change, *, now_s: float) -> Taken | None:
        """Process a put under the number of its key; None: it changes nothing."""
        taken = self._answer(robot, change, now_s)
        if taken is not None:
            self._take(taken, now_s)
        return taken

    def restart(self, *, now_s: float) -> Taken:
        """Rule 5."""
        stopped = self.fence.may is May.STOPPED
        taken = self._of_operator(May.STOPPED if stopped else May.NOBODY, Cause.WORLD_RESTARTED)
        self._take(taken, now_s)
        return taken

    def _answer(self, robot: int, change: Change, now_s: float) -> Taken | None:
        by_operator, stopped = robot == NOBODY_NUMBER, self.fence.may is May.STOPPED
        match change:
            case Raise():
                return self._answer_raise(robot, change, now_s)
            case Turn(fence=fence):
                return Taken(fence) if self._follows(robot, fence) else None
            case Stop():
                takes = by_operator and not stopped
                return self._of_operator(May.STOPPED, Cause.OPERATOR) if takes else None
            case Release(generation=generation):
                takes = by_operator and stopped and generation == self.fence.epoch.generation
                return self._of_operator(May.NOBODY, Cause.OPERATOR) if takes else None
            case _:
                assert_never(change)

    def _answer_raise(self, robot: int, change: Raise, now_s: float) -> Taken | None:
        if not self._wins(robot, change.epoch) or not self._quotas.may_raise(robot, now_s):
            return None
        asks = change.cause is Cause.OUTSIDERS and self.fence.may is May.ALL
        if asks and not self._outsiders_win(robot, now_s):
            return None
        return Taken(Fence(epoch=change.epoch), change.cause)

    def _wins(self, robot: int, epoch: Epoch) -> bool:
        """Rules 2 and 6."""
        now = self.fence
        if robot not in self._robots or epoch.robot != robot or epoch.life == 0 or now.may is May.STOPPED:
            return False
        if epoch.generation == now.epoch.generation + 1:
            return True
        is_tie = epoch.generation == now.epoch.generation and now.turn == 0
        return is_tie and epoch.robot > now.epoch.robot

    def _outsiders_win(self, robot: int, now_s: float) -> bool:
        """Rule 7: hold the raise of one more outsider; whether they are enough now."""
        self._asked_s[robot] = now_s
        lately = [each for each, asked_s in self._asked_s.items() if now_s - asked_s <= OUTSIDERS_S]
        return len(lately) > self.fence.members

    def _follows(self, robot: int, fence: Fence) -> bool:
        """Rules 3 and 6."""
        now = self.fence
        is_next = (fence.epoch, fence.turn) == (now.epoch, now.turn + 1) and now.may is not May.ALL
        return is_next and robot == now.epoch.robot != NOBODY_NUMBER and self._is_whole(fence)

    def _is_whole(self, fence: Fence) -> bool:
        """Whether a turn names whom it has to name, and nobody else."""
        match fence.may:
            case May.NOBODY:
                return (fence.robot, fence.life, fence.members) == (NOBODY_NUMBER, 0, 0)
            case May.ONE:
                return fence.robot in self._robots and fence.life != 0 and fence.members == 0
            case May.ALL:
                return fence.robot in self._robots and 1 <= fence.members <= len(self._robots)
            case May.STOPPED:
                return False
            case _:
                assert_never(fence.may)

    def _of_operator(self, may: May, cause: Cause) -> Taken:
        return Taken(Fence(epoch=self.fence.epoch.next(NOBODY_NUMBER, 0), may=may), cause)

    def _take(self, taken: Taken, now_s: float) -> None:
        before, self.fence = self.fence, taken.fence
        self._asked_s = {}
        self._quotas.hear(before, taken.fence, now_s)
