"""The world's connection to its router, and how long it was lost [wall-clock seconds]. Pure.

Rule 1: if another router takes over between two looks, both `router.lost` and `router.found` are recorded.
Rule 2: a router that was never there is lost from the first look on. No entry says so: none may be up yet.
Rule 3: a pause of our own counts as `LOOK_S_MAX` at most: a world that was frozen has not lost its router.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from protocol.timeline import Record, RouterFound, RouterLost

LOOK_S_MAX = 2.0  # a world looks every 0.1 s; on a busy machine its turns were late by up to 2 s


@dataclass(slots=True)
class Routing:
    """The world's view of its router."""

    _router: str | None = None
    _seen_wall_s: float = math.inf
    """When there last was a router; until there is one, when we first looked (rule 2)."""
    _looked_wall_s: float = math.inf
    _lost: bool = False

    def look(self, router: str | None, *, wall_s: float) -> Iterator[Record]:
        """Note the connected router; yields the entries to record."""
        self._seen_wall_s = min(self._seen_wall_s, wall_s)
        self._seen_wall_s += max(wall_s - self._looked_wall_s - LOOK_S_MAX, 0.0)  # rule 3
        self._looked_wall_s = wall_s
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
        """How long there has been no router; 0 while there is one."""
        return wall_s - self._seen_wall_s if self._lost or self._router is None else 0.0
