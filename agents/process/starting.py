"""Which robots a host starts when. Pure: it forks nothing.

Rule 1: few robots are on their way to a session at a time. A thousand at once keep each other and the router
        from it for longer than a handshake may take.
Rule 2: a robot is on its way until it says that it is connected, or its process has ended.
Rule 3: a robot is not started while a former process of it still ends: both would have the same session.
"""

from collections import OrderedDict
from collections.abc import Collection, Iterable
from typing import Generic, TypeVar

# Without a limit, at load 100, up to 43 of 1,000 were on their way at a time, and a handshake took up to 2.8
# of the 3 s that it may take (`OPEN_TIMEOUT_MS`).
CONNECTING_MAX = 8

Place = TypeVar("Place")


class Starting(Generic[Place]):
    """The robots of a host that wait for their start, and the processes that have no session yet."""

    def __init__(self) -> None:
        self._waiting: OrderedDict[Place, set[int]] = OrderedDict()
        """Each with the processes that must end before it is started."""
        self._held: set[Place] = set()
        self._connecting: set[int] = set()

    def wait(self, place: Place, *, after: Iterable[int] = ()) -> None:
        """A robot is to be started after these processes; if it waits already, it is started once."""
        self._waiting.setdefault(place, set(after))

    def forget(self, place: Place) -> bool:
        """A robot is not to be started any more; returns whether it was waiting."""
        was_waiting = place in self._waiting
        self._waiting.pop(place, None)
        self._held.discard(place)
        return was_waiting

    def hold(self, place: Place) -> None:
        """A robot that waits is not started until it is let go."""
        if place in self._waiting:
            self._held.add(place)

    def let_go(self, place: Place) -> None:
        """A robot may be started again."""
        self._held.discard(place)

    @property
    def held(self) -> Collection[Place]:
        """The robots that are not started until they are let go."""
        return self._held

    def next(self) -> Place | None:
        """The robot to start now; None: nobody waits who may be started, or enough are on their way."""
        if len(self._connecting) >= CONNECTING_MAX:
            return None
        may_start = (each for each, after in self._waiting.items() if not after and each not in self._held)
        place = next(may_start, None)
        if place is not None:
            del self._waiting[place]
        return place

    def began(self, pid: int) -> None:
        """A process has been started."""
        self._connecting.add(pid)

    def arrived(self, pids: Iterable[int]) -> None:
        """These processes are connected."""
        self._connecting.difference_update(pids)

    def ended(self, pid: int) -> None:
        """A process has ended."""
        self._connecting.discard(pid)
        for after in self._waiting.values():
            after.discard(pid)

    def end(self) -> None:
        """Nobody is started any more."""
        self._waiting.clear()
        self._held.clear()
