"""The port to the network: what a shell can send, and what can arrive; `zenoh_transport` implements it.

Rule 1: everything arrives through one bounded inbox, in order of arrival. A full inbox drops its oldest
        arrival and counts it.
Rule 2: nothing here waits for the network: `put` and `ask` return at once and may lose the message.
Rule 3: a message that cannot be decoded becomes `Refused`; it never raises in the receiver.
"""

from collections.abc import Callable, Collection, Sequence
from typing import Protocol

from msgspec import Struct

from protocol.network.traffic import Traffic
from protocol.wire.messages import Message


class Heard(Struct, frozen=True):
    """A message on a subscribed key, or the reply to a query (then `number` is 0)."""

    key: str
    number: int
    message: Message


class Asked(Struct, frozen=True):
    """A query; `answer` replies and may be called once."""

    key: str
    message: Message
    answer: Callable[[Message], None]


class Appeared(Struct, frozen=True):
    """A liveliness token has appeared. It may be told twice."""

    key: str


class Vanished(Struct, frozen=True):
    """A liveliness token has vanished: its process ended, or the router lost it for a moment."""

    key: str


class Refused(Struct, frozen=True):
    """A message broke the protocol; it was counted and dropped."""

    key: str
    reason: str


class Listed(Struct, frozen=True):
    """All tokens on the patterns that are watched, and that were shown, have appeared."""

    key: str = ""
    """It has none."""


Arrival = Heard | Asked | Appeared | Vanished | Refused | Listed


class Transport(Protocol):
    """The network as a shell needs it."""

    @property
    def traffic(self) -> Traffic:
        """Messages sent and received so far, by key."""

    @property
    def router(self) -> str | None:
        """The unique name of the connected router; None while there is none."""

    def put(self, key: str, message: Message) -> None:
        """Send to all subscribers of the key; the message may be lost; never blocks."""

    def ask(self, key: str, message: Message) -> None:
        """Query the key; the reply arrives as `Heard`, or is lost: then ask again."""

    async def arrivals(self, timeout_s: float | None) -> Sequence[Arrival]:
        """Wait for arrivals and return all of them; empty after the timeout, and rarely before it."""

    def watch(self, patterns: Collection[str]) -> None:
        """Watch the tokens on these patterns from now on, and no others; `Listed` follows."""

    def timestamp(self) -> str:
        """A new hybrid-logical-clock time stamp of this process."""
