"""Which router carries the world, and for how long none does [wall-clock seconds]. Pure.

Rule 1: a router that takes over from another within one look was lost and found in it.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from protocol.timeline import Record, RouterFound, RouterLost


@dataclass(slots=True)
class Routing:
    """What the world knows of its router."""

    _router: str | None = None
    _seen_wall_s: float = 0.0
    _lost: bool = False

    def look(self, router: str | None, *, wall_s: float) -> Iterator[Record]:
        """See which router there is now; what is to be recorded of that."""
        if self._router is not None and router != self._router and not self._lost:
            self._lost = True
            yield RouterLost()
        if router is None:
            return
        if self._lost:
            self._lost = False
            yield RouterFound(away_s=wall_s - self._seen_wall_s)
        self._router, self._seen_wall_s = router, wall_s

    def away_s(self, wall_s: float) -> float:
        """For how long there has been none; 0 while there is one."""
        return wall_s - self._seen_wall_s if self._lost else 0.0
