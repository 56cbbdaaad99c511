"""A transport around another one: it passes everything on, except what a subclass overrides."""

from collections.abc import Collection, Sequence

from protocol.network.traffic import Traffic
from protocol.network.transport import Arrival, Transport
from protocol.wire.messages import Message


class AroundTransport:
    """The inner transport, with its contract (`protocol.network.transport`)."""

    def __init__(self, inner: Transport) -> None:
        self._inner = inner

    @property
    def traffic(self) -> Traffic:
        """Messages sent and received so far, by key."""
        return self._inner.traffic

    @property
    def router(self) -> str | None:
        """The unique name of the connected router; None while there is none."""
        return self._inner.router

    def put(self, key: str, message: Message) -> None:
        """Send to all subscribers of the key; the message may be lost; never blocks."""
        self._inner.put(key, message)

    def ask(self, key: str, message: Message) -> None:
        """Query the key; the reply arrives as `Heard`, or is lost: then ask again."""
        self._inner.ask(key, message)

    async def arrivals(self, timeout_s: float | None) -> Sequence[Arrival]:
        """Wait for arrivals and return all of them; empty after the timeout."""
        return await self._inner.arrivals(timeout_s)

    def watch(self, patterns: Collection[str]) -> None:
        """Watch the tokens on these patterns from now on, and no others; `Listed` follows."""
        self._inner.watch(patterns)

    def timestamp(self) -> str:
        """A new hybrid-logical-clock time stamp of this process."""
        return self._inner.timestamp()
