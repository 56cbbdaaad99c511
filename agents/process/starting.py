"""Which robots a host starts when. Pure: it forks nothing.

Rule 1: few robots are on their way to a session at a time. A thousand at once keep each other and the router
        from it for longer than a handshake may take.
Rule 2: a robot is on its way until it says that it is connected, or its process has ended.
"""

from collections import OrderedDict
from collections.abc import Iterable
from typing import Generic, TypeVar

# Without a limit, at load 100, up to 43 of 1,000 were on their way at a time, and a handshake took up to 2.8
# of the 3 s that it may take (`OPEN_TIMEOUT_MS`).
CONNECTING_MAX = 8

Place = TypeVar("Place")


class Starting(Generic[Place]):
    """The robots of a host that wait for their start, and the processes that have no session yet."""

    def __init__(self) -> None:
        self._waiting: OrderedDict[Place, None] = OrderedDict()
        self._connecting: set[int] = set()

    def wait(self, place: Place) -> None:
        """A robot is to be started; if it waits already, it is started once."""
        self._waiting.setdefault(place)

    def forget(self, place: Place) -> bool:
        """A robot is not to be started any more; returns whether it was waiting."""
        was_waiting = place in self._waiting
        self._waiting.pop(place, None)
        return was_waiting

    def next(self) -> Place | None:
        """The robot to start now; None: nobody waits, or enough are on their way."""
        if not self._waiting or len(self._connecting) >= CONNECTING_MAX:
            return None
        place, _ = self._waiting.popitem(last=False)
        return place

    def began(self, pid: int) -> None:
        """A process has been started."""
        self._connecting.add(pid)

    def arrived(self, pids: Iterable[int]) -> None:
        """These processes are connected, or have ended."""
        self._connecting.difference_update(pids)

    def end(self) -> None:
        """Nobody is started any more."""
        self._waiting.clear()
