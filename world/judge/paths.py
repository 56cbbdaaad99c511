"""The paths of strands: what the formation laid, and then the targets of the leader's switching steps.

Arc length 0 is where the laid path begins, at the tail. Each path is built once.
"""

from protocol.path import Path
from protocol.timeline import StrandFormed
from world.judge.evidence import JOINS, Evidence


class Paths:
    """The paths of complete evidence: it must not change while paths are requested."""

    def __init__(self, evidence: Evidence) -> None:
        self._evidence = evidence
        self._known: dict[int, Path] = {}
        """By epoch."""

    def of(self, strand: StrandFormed) -> Path | None:
        """The strand's path; None if its formation has none."""
        if not strand.laid:
            return None
        if strand.epoch not in self._known:
            self._known[strand.epoch] = self._driven(strand)
        return self._known[strand.epoch]

    def _driven(self, strand: StrandFormed) -> Path:
        path = Path(strand.laid)
        steps = strand.order[0], strand.epoch
        plans = self._evidence.plans.get(steps, {})
        targets = {step: planned[-1][1].target for step, planned in plans.items() if step != JOINS}
        targets |= self._evidence.abandoned.get(steps, {})
        for step in sorted(targets):
            path.extend(targets[step])
        return path
