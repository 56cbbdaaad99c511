"""The liveliness tokens of a rehearsal, as Zenoh's router has them: who sees whose, and what changes. Pure.

Rule 1: the token of a process that ends goes at once, since its connection does.
Rule 2: one that is frozen, or cut off from the router, loses its token when the router's lease of it runs
        out; one that is cut off sees nobody's by then. Both come back at once.
Rule 3: nobody sees its own.
"""

import math
from dataclasses import dataclass

LEASE_S = 1.0  # `LEASE_MS` of `protocol.network.settings`


@dataclass(frozen=True, slots=True)
class Change:
    """A token has come or gone, as one process sees it."""

    observer: int
    process: int
    incarnation: str
    came: bool


class Tokens:
    """Processes by number, the world's is 0."""

    def __init__(self) -> None:
        self._shown: dict[int, str] = {}
        self._frozen_s: dict[int, float] = {}
        self._cut_s: dict[int, float] = {}
        self._seen: dict[int, dict[int, str]] = {}
        self._look_at_s = -math.inf
        """Before then nothing changes, unless something is done."""

    def show(self, process: int, incarnation: str) -> None:
        """A process has begun."""
        self._shown[process] = incarnation
        self._seen[process] = {}
        self._frozen_s.pop(process, None)
        self._look_at_s = -math.inf

    def end(self, process: int) -> None:
        """A process is no more."""
        self._shown.pop(process, None)
        self._seen.pop(process, None)
        self._look_at_s = -math.inf

    def forget(self, observer: int) -> None:
        """A process is told anew of all that there are."""
        self._seen[observer] = {}
        self._look_at_s = -math.inf

    def freeze(self, process: int, now_s: float) -> None:
        """A process does nothing any more."""
        self._frozen_s.setdefault(process, now_s)
        self._look_at_s = -math.inf

    def thaw(self, process: int) -> None:
        """It goes on."""
        self._frozen_s.pop(process, None)
        self._look_at_s = -math.inf

    def cut(self, processes: set[int], now_s: float) -> None:
        """These are cut off from the router now, and no others."""
        if processes == self._cut_s.keys():
            return
        self._cut_s = {process: self._cut_s.get(process, now_s) for process in sorted(processes)}
        self._look_at_s = -math.inf

    def changes(self, now_s: float) -> list[Change]:
        """What has changed since the last time, in one order whatever the order of hashes."""
        if now_s < self._look_at_s:
            return []
        leases_s = [since_s + LEASE_S for since_s in (*self._frozen_s.values(), *self._cut_s.values())]
        self._look_at_s = min((lease_s for lease_s in leases_s if lease_s > now_s), default=math.inf)
        listed = {
            process: incarnation
            for process, incarnation in sorted(self._shown.items())
            if not self._is_lost(self._frozen_s.get(process), now_s)
            and not self._is_lost(self._cut_s.get(process), now_s)
        }
        changes: list[Change] = []
        for observer in sorted(self._seen):
            alone = self._is_lost(self._cut_s.get(observer), now_s)
            sees = {} if alone else {each: listed[each] for each in listed if each != observer}
            changes += _differences(observer, self._seen[observer], sees)
            self._seen[observer] = sees
        return changes

    def _is_lost(self, since_s: float | None, now_s: float) -> bool:
        return since_s is not None and now_s >= since_s + LEASE_S


def _differences(observer: int, before: dict[int, str], after: dict[int, str]) -> list[Change]:
    gone = [each for each in before.items() if after.get(each[0]) != each[1]]
    come = [each for each in after.items() if before.get(each[0]) != each[1]]
    return [Change(observer, *each, came=False) for each in gone] + [
        Change(observer, *each, came=True) for each in come
    ]
