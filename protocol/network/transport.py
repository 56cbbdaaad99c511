"""The port to the network: what a shell may do, and what may arrive; `zenoh_transport` has it.

Rule 1: everything that arrives comes through one bounded inbox, in the order of arrival; what a full
        inbox drops (the oldest) is counted.
Rule 2: nothing here waits for the network: `put` and `ask` return at once and may lose the message.
Rule 3: a message that does not decode becomes `Refused`; it never raises in the receiver.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from protocol.network.traffic import Traffic
from protocol.wire.messages import Message


@dataclass(frozen=True, slots=True)
class Heard:
    """A message that somebody put, or the answer to something asked (then `number` is 0)."""

    key: str
    number: int
    message: Message


@dataclass(frozen=True, slots=True)
class Asked:
    """Somebody asks; `answer` replies and may be called once."""

    key: str
    message: Message
    answer: Callable[[Message], None]


@dataclass(frozen=True, slots=True)
class Appeared:
    """A liveliness token has come."""

    key: str


@dataclass(frozen=True, slots=True)
class Vanished:
    """A liveliness token has gone: its process ended, or the router lost it for a moment."""

    key: str


@dataclass(frozen=True, slots=True)
class Refused:
    """A message broke the protocol; it has been counted and dropped."""

    key: str
    reason: str


Arrival = Heard | Asked | Appeared | Vanished | Refused


class Transport(Protocol):
    """What a shell needs of a network."""

    @property
    def traffic(self) -> Traffic:
        """Messages sent and received so far, by key."""

    @property
    def router(self) -> str | None:
        """The router at the other end, by a name that no other router has; None while there is none."""

    def put(self, key: str, message: Message) -> None:
        """Send to whoever subscribes to the key; may be lost, never blocks."""

    def ask(self, key: str, message: Message) -> None:
        """Query the key; the answer arrives as `Heard`, or never: ask again."""

    async def arrivals(self, timeout_s: float | None) -> Sequence[Arrival]:
        """Wait for arrivals and take all of them; empty when the time is up."""

    def timestamp(self) -> str:
        """A new hybrid-logical-clock time stamp of this process."""
