"""How far each robot has let the one behind it drive, at which time. Grants of a link never shrink here.

In the epoch in force no check asks for a time before the world's newest order and the oldest undecided
check. So for each link only the newest grant up to that time is kept, and all later ones.
"""

from bisect import bisect_right
from collections.abc import Collection
from operator import itemgetter

from protocol.timeline import AuthorityGranted
from world.judge.rules.claims import ROUNDING_S

Link = tuple[int, int, int]
"""Granter, grantee, epoch."""
_T_S = itemgetter(0)


class Grants:
    """The largest authority of each link, by time."""

    def __init__(self) -> None:
        self._granted: dict[Link, list[tuple[float, float]]] = {}
        self._epoch = 0
        self._asked_s = 0.0

    def hear(self, robot: int, t_s: float, grant: AuthorityGranted) -> None:
        """A robot has recorded a grant."""
        granted = self._granted.setdefault((robot, grant.to, grant.epoch), [])
        granted.append((t_s, max(grant.authority_m, granted[-1][1] if granted else 0.0)))
        if grant.epoch == self._epoch:
            by_then = bisect_right(granted, self._asked_s, key=_T_S)
            del granted[: max(by_then - 1, 0)]

    def advance(self, epoch: int, asked_s: float) -> None:
        """This epoch is in force, and nobody asks for an earlier time of it any more."""
        self._epoch, self._asked_s = epoch, asked_s

    def by(self, link: Link, t_s: float) -> float:
        """The largest authority that the link had been granted by this time."""
        granted = self._granted.get(link, ())
        by_then = bisect_right(granted, t_s + ROUNDING_S, key=_T_S)
        return granted[by_then - 1][1] if by_then else 0.0

    def forget(self, kept: Collection[int]) -> None:
        """Drop all other epochs."""
        self._granted = {link: granted for link, granted in self._granted.items() if link[2] in kept}
