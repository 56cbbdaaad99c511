"""The liveliness tokens of a rehearsal, as with Zenoh's router: which process sees which token. Pure.

Rule 1: when a process ends, its token goes at once, since its connection is closed.
Rule 2: a process that is frozen or cut off from the router loses its token when the router's lease expires.
        By then, a process that is cut off sees no tokens. Both come back at once.
Rule 3: no process sees its own token.
Rule 4: a process that has seen nothing, or begins to watch others, sees all their tokens at one look.
Rule 5: a robot watches the tokens of the robots that it names, and the world's; the world watches all. A
        process is told when it has seen all that it has begun to watch. It is not told what it has ceased to
        watch.
"""

import math
from dataclasses import dataclass

from protocol.keys import WORLD_NUMBER

LEASE_S = 1.0  # `LEASE_MS` of `protocol.network.settings`


@dataclass(frozen=True, slots=True)
class Change:
    """A token has appeared or gone for one observer."""

    observer: int
    process: int
    incarnation: str
    came: bool


@dataclass(frozen=True, slots=True)
class Look:
    """The tokens that one observer sees when it connects, or begins to watch them."""

    observer: int
    shown: dict[int, str]


@dataclass(frozen=True, slots=True)
class Watched:
    """One observer has seen all tokens that it has begun to watch (rule 5)."""

    observer: int
    robots: frozenset[int] | None
    """None: of all."""


Seen = Change | Look | Watched


class Tokens:
    """The tokens of all processes, by number; the world is 0."""

    def __init__(self) -> None:
        self._shown: dict[int, str] = {}
        self._frozen_s: dict[int, float] = {}
        self._cut_s: dict[int, float] = {}
        self._seen: dict[int, dict[int, str]] = {}
        self._watched: dict[int, frozenset[int] | None] = {}
        """The robots that each watches; None: all."""
        self._begun: set[int] = set()
        """The robots that have begun to watch since the last look."""
        self._look_at_s = -math.inf
        """No token changes before this time, unless a method is called."""

    def show(self, process: int, incarnation: str) -> None:
        """Show the token of a process that has started."""
        self._shown[process] = incarnation
        self._seen[process] = {}
        self._frozen_s.pop(process, None)
        self._look_at_s = -math.inf

    def watch(self, observer: int, robots: frozenset[int] | None) -> None:
        """From now on this process watches the world's token and those of these robots; None: of all."""
        self._watched[observer] = robots
        self._begun.add(observer)
        seen = self._seen[observer]
        self._seen[observer] = {each: seen[each] for each in seen if _is_watched(each, robots)}
        self._look_at_s = -math.inf

    def end(self, process: int) -> None:
        """Remove the token of a process that has ended."""
        self._shown.pop(process, None)
        self._seen.pop(process, None)
        self._watched.pop(process, None)
        self._begun.discard(process)
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

    def changes(self, now_s: float) -> list[Seen]:
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
        changes: list[Seen] = []
        for observer in sorted(self._seen):
            alone = self._is_lost(self._cut_s.get(observer), now_s)
            sees = {} if alone else self._seen_by(observer, listed)
            changes += self._told(observer, sees)
            self._seen[observer] = sees
        self._begun.clear()
        return changes

    def _seen_by(self, observer: int, listed: dict[int, str]) -> dict[int, str]:
        """What an observer sees of the tokens that are shown (rules 3 and 5)."""
        robots = self._watched.get(observer)
        seen = listed if robots is None else (WORLD_NUMBER, *sorted(robots))
        return {each: listed[each] for each in seen if each in listed and each != observer}

    def _told(self, observer: int, sees: dict[int, str]) -> list[Seen]:
        """What an observer is told of what it sees now (rules 4 and 5)."""
        before, told = self._seen[observer], list[Seen]()
        if sees and not before:
            told = [Look(observer, sees)]
        elif sees != before:
            told = _differences(observer, before, sees, at_once=observer in self._begun)
        if observer in self._begun:
            told.append(Watched(observer, self._watched[observer]))
        return told

    def _is_lost(self, since_s: float | None, now_s: float) -> bool:
        return since_s is not None and now_s >= since_s + LEASE_S


def _is_watched(process: int, robots: frozenset[int] | None) -> bool:
    return robots is None or process == WORLD_NUMBER or process in robots


def _differences(
    observer: int, before: dict[int, str], after: dict[int, str], *, at_once: bool
) -> list[Seen]:
    gone = [Change(observer, *each, came=False) for each in before.items() if after.get(each[0]) != each[1]]
    come = {process: token for process, token in after.items() if before.get(process) != token}
    if at_once and come:
        return [*gone, Look(observer, come)]
    return [*gone, *(Change(observer, *each, came=True) for each in come.items())]
