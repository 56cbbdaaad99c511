"""The paths of strands that follow from the evidence.

Rule 1: the strand's path is a polyline. It begins with the places where the robots lined up, tail first;
        robots that stayed in a strand keep their path between them. Then follow the targets of the leader's
        switching steps. After a reversal it is the old path reversed, followed by the new leader's targets;
        the new leader may drive along the old part.
Rule 2: each path is built once, without recursion: a log may contain any number of reversals.
"""

import math

from protocol.frames import Point
from protocol.path import Path
from protocol.timeline import OrderAccepted, PoseSampled, StrandFormed
from world.judge.evidence import ROUNDING_M, Evidence, apart_m


class Paths:
    """The paths of complete evidence: it must not change while paths are requested."""

    def __init__(self, evidence: Evidence) -> None:
        self._evidence = evidence
        self._known: dict[tuple[tuple[int, ...], int], Path | None] = {}
        """By order and epoch."""

    def of(self, strand: StrandFormed) -> Path | None:
        """The strand's path; None if one of its robots has no pose, or its reversal is missing."""
        if not all(self._evidence.poses.get(robot) for robot in strand.order):
            return None
        return self._path(strand.order, strand.epoch)

    def laid(self, order: tuple[int, ...], epoch: int) -> Path | None:
        """The strand's path at the beginning of the epoch."""
        if epoch - 1 in self._evidence.lining_up:
            return self._lined_up(order, epoch)
        reversal = self._evidence.reversals.get(epoch - 1)
        before = None if reversal is None else self._path(order[::-1], epoch - 1)
        return None if reversal is None or before is None else before.reversed(reversal.cut_m, reversal.end_m)

    def _path(self, order: tuple[int, ...], epoch: int) -> Path | None:
        """Go back along the reversals to a path that is known or needs no other, then forward again."""
        wanted = each = order, epoch
        chain = []
        while each not in self._known:
            chain.append(each)
            if not self._continues(each[1]):
                break
            each = each[0][::-1], each[1] - 1
        for each in reversed(chain):
            self._known[each] = self._driven(*each)
        return self._known[wanted]

    def _continues(self, epoch: int) -> bool:
        """Whether this epoch's path continues the reversed path of the epoch before."""
        return epoch - 1 not in self._evidence.lining_up and epoch - 1 in self._evidence.reversals

    def _driven(self, order: tuple[int, ...], epoch: int) -> Path | None:
        path = self.laid(order, epoch)
        plans = self._evidence.plans.get(order[0], ())
        targets = {plan.step: plan.target for _, plan in plans if plan.epoch == epoch}
        targets |= self._evidence.abandoned.get((order[0], epoch), {})
        for step in sorted(targets) if path is not None else []:
            assert path is not None
            path.extend(targets[step])
        return path

    def _lined_up(self, order: tuple[int, ...], epoch: int) -> Path:
        starts = [self._lined_up_at(robot, epoch) for robot in reversed(order)]
        path = Path(Point(x_m=start.x_m, y_m=start.y_m) for start in starts)
        formed = self._evidence.strands.get((order[0], epoch))
        bent = Path(formed.laid) if formed is not None and formed.laid else None
        # The leader's own path counts only if it begins and ends where the robots stood.
        both = bent is not None and all(
            apart_m(path.at(end), bent.at(end)) <= ROUNDING_M for end in (0.0, math.inf)
        )
        return bent if bent is not None and both else path

    def _lined_up_at(self, robot: int, epoch: int) -> OrderAccepted | PoseSampled:
        """Where a robot stood when the strand formed: the place of its first order after that."""
        first = (order for _, order in self._evidence.orders.get(robot, ()) if order.epoch >= epoch)
        return next(first, self._evidence.poses[robot][-1][1])
