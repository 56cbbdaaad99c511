"""How a robot proposes a view: it waits for a drawn time, and puts its raise until odometry tells it.

Rule 1: after an epoch that has not come to ALL (common knowledge from the fence) the time is drawn from the
        robot's life and the generation, doubled with each such epoch in a row, so that two robots do not
        raise in turn for ever. What all may want at once is drawn from a longer time in a larger fleet.
Rule 2: nobody raises over a stop.
Rule 3: over ALL a robot that is left out raises as an outsider: the register takes it when enough ask.
"""

from dataclasses import dataclass
from hashlib import blake2b

from agents.commands import Command, Note, Put
from agents.due import is_due
from agents.liveness.reason import Reason
from agents.liveness.timing import Timing
from protocol.fence import Cause, Epoch, Fence, May, Raise
from protocol.timeline import ViewProposed

SHARED = frozenset({Cause.START, Cause.COORDINATOR_LOST})  # what all robots may want at once


@dataclass(slots=True)
class Raising:
    """The raises of one robot."""

    robot: int
    life: int
    timing: Timing
    reason: Reason | None = None
    """Why it has put its newest raise."""
    _noted: tuple[Epoch, Cause, int | None] | None = None
    """What it proposes now, of which there is a record; None: nothing."""
    _wanted_since_s: float | None = None
    _put_at_s: float = -float("inf")
    _all_in: int | None = None
    """The newest generation that has come to ALL, as far as it was told; at first the one before."""

    def enter(self, fence: Fence) -> None:
        """Odometry tells a newer fence: whatever was wanted is to be wanted anew."""
        self._wanted_since_s = None
        if fence.may is May.ALL:
            self._all_in = fence.epoch.generation
        elif self._all_in is None:
            self._all_in = max(fence.epoch.generation - 1, 0)

    def in_vain(self, generation: int) -> int:
        """How many generations in a row, up to this one, have not come to ALL."""
        return 0 if self._all_in is None else max(generation - self._all_in, 0)

    def want(self, reason: Reason | None, fence: Fence, now_s: float) -> list[Command]:
        """Propose a view if there is a reason to, and the drawn time has passed."""
        if reason is None or fence.may is May.STOPPED:
            self._wanted_since_s = self._noted = None
            return []
        if self._wanted_since_s is None:
            self._wanted_since_s = now_s
        if now_s - self._wanted_since_s < self._draw_s(reason, fence.epoch.generation):
            return []
        if not is_due(last_s=self._put_at_s, every_s=self.timing.put_s, now_s=now_s):
            return []
        self._put_at_s, self.reason = now_s, reason
        epoch = fence.epoch.next(self.robot, self.life)
        put = Put(Raise(epoch=epoch, cause=reason.cause))
        proposal = (epoch, reason.cause, reason.about)
        if proposal == self._noted:
            return [put]
        self._noted = proposal
        proposed = ViewProposed(epoch=epoch.number, cause=reason.cause, about=reason.about, why=reason.why)
        return [Note(proposed), put]

    def _draw_s(self, reason: Reason, generation: int) -> float:
        """Rule 1."""
        drawn = blake2b(f"{self.life}/{generation}".encode(), digest_size=4).digest()
        share = int.from_bytes(drawn) / 2**32
        doubled = min(self.in_vain(generation), self.timing.doublings_max)
        if reason.cause in SHARED:
            return self.timing.shared_draws_s * share * 2.0**doubled
        return self.timing.draws_s * (1.0 + share) * 2.0 ** (doubled - 1) if doubled else 0.0
