"""The liveliness tokens of a rehearsal, as with Zenoh's router: which process sees which token. Pure.

Rule 1: when a process ends, its token goes at once, since its connection is closed.
Rule 2: a process that is frozen or cut off from the router loses its token when the router's lease expires.
        By then, a process that is cut off sees no tokens. Both come back at once.
Rule 3: no process sees its own token.
Rule 4: a process that sees nothing yet sees all tokens at one look: a fleet has too many pairs of processes
        for a change of each.
"""

import math
from dataclasses import dataclass

LEASE_S = 1.0  # `LEASE_MS` of `protocol.network.settings`


@dataclass(frozen=True, slots=True)
class Change:
    """A token has appeared or gone for one observer."""

    observer: int
    process: int
    incarnation: str
    came: bool


@dataclass(frozen=True, slots=True)
class FirstLook:
    """All tokens that one observer sees when it connects."""

    observer: int
    shown: dict[int, str]


class Tokens:
    """The tokens of all processes, by number; the world is 0."""

    def __init__(self) -> None:
        self._shown: dict[int, str] = {}
        self._frozen_s: dict[int, float] = {}
        self._cut_s: dict[int, float] = {}
        self._seen: dict[int, dict[int, str]] = {}
        self._look_at_s = -math.inf
        """No token changes before this time, unless a method is called."""

    def show(self, process: int, incarnation: str) -> None:
        """Show the token of a process that has started."""
        self._shown[process] = incarnation
        self._seen[process] = {}
        self._frozen_s.pop(process, None)
        self._look_at_s = -math.inf

    def end(self, process: int) -> None:
        """Remove the token of a process that has ended."""
        self._shown.pop(process, None)
        self._seen.pop(process, None)
        self._look_at_s = -math.inf

    def forget(self, observer: int) -> None:
        """Report all tokens to this process again."""
        self._seen[observer] = {}
        self._look_at_s = -math.inf

    def freeze(self, process: int, now_s: float) -> None:
        """A process is frozen."""
        self._frozen_s.setdefault(process, now_s)
        self._look_at_s = -math.inf

    def thaw(self, process: int) -> None:
        """A frozen process goes on."""
        self._frozen_s.pop(process, None)
        self._look_at_s = -math.inf

    def cut(self, processes: set[int], now_s: float) -> None:
        """Exactly these processes are cut off from the router now."""
        if processes == self._cut_s.keys():
            return
        self._cut_s = {process: self._cut_s.get(process, now_s) for process in sorted(processes)}
        self._look_at_s = -math.inf

    def changes(self, now_s: float) -> list[Change | FirstLook]:
        """The changes since the last call, in an order that does not depend on hashes."""
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
        changes: list[Change | FirstLook] = []
        for observer in sorted(self._seen):
            alone = self._is_lost(self._cut_s.get(observer), now_s)
            sees = {} if alone else dict(listed)
            sees.pop(observer, None)
            if sees and not self._seen[observer]:
                changes.append(FirstLook(observer, sees))
            elif sees != self._seen[observer]:
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
