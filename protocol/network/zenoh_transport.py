"""The transport port over Zenoh. A shell: it moves bytes and counts them.

Rule 1: Zenoh's threads only append to the inbox. Callbacks are direct, so the order is that of the link.
        Everything is decoded in the event loop.
Rule 2: a session is always closed: with an open subscriber the interpreter would never end.
Rule 3: all messages use congestion control DROP, which blocks the loop for 1 ms at most, and one priority,
        since a higher one would overtake. They are not express: that is no faster here (0.5 ms round trip),
        and it lost 20 % or more in bursts of 1000, where batches lost nothing.
Rule 4: only messages through the router are received: a session would otherwise receive its own forgeries.
Rule 5: some bytes, which no router should send, make Zenoh panic. Then its locks stay poisoned and the
        session is unusable: the process ends, and the fleet continues as after a crash. A process that
        receives nothing tests its session, since it may send nothing either, and its token would stay.
Rule 6: a session that watches tokens and is deaf (`deafness.py`) is closed, and another takes its place in
        this process: with the same subscriptions, the same token, and message numbers that go on.
Rule 7: which tokens are watched can change. A query behind each new subscription tells the tokens that are
        there, and its end that these are all. So a token may be told twice. One that is not watched any more
        is not told.
Rule 8: without a publisher the router looks for the receivers of each put anew, among all keys (266 us with
        1,000 robots, by a publisher 4 us), unless somebody subscribes to this very key, as to all that the
        world says. A publisher costs the router 0.3 ms or more, once. So keys that are used often have one.
"""

import asyncio
import contextlib
import logging
import math
import os
import time
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import msgspec
import zenoh
from msgspec import Struct
from zenoh.handlers import Callback

from protocol.errors import MessageRefusedError, SessionLostError, UsageError
from protocol.keys import WORLD, matches
from protocol.network.bounded import INBOX_BYTES_MAX, INBOX_CAPACITY
from protocol.network.deafness import Deafness
from protocol.network.inbox import Inbox, alarm
from protocol.network.session import Session
from protocol.network.settings import CLIENT_THREADS, ask_timeout_ms, client_settings, connect_s
from protocol.network.traffic import Traffic
from protocol.network.transport import Appeared, Arrival, Asked, Heard, Listed, Refused, Vanished
from protocol.wire.codec import decode, encode
from protocol.wire.messages import Message

log = logging.getLogger("network")

KEY_LENGTH_MAX = 200  # our keys have less than 160 characters; the timeline accepts up to 200
LIST_TIMEOUT_S = 10.0  # for a router with much to do: some thousand tokens are told in a second
DROP, REMOTE = zenoh.CongestionControl.DROP, zenoh.Locality.REMOTE  # rules 3 and 4
OFTEN = 3  # puts on one key: orders and link states; what is told of a view ends before
RETRY_S = 0.1  # wall: a try that no router answers is cheap
PULSE_S = 0.2  # wall: 1/5 of the silence after which a robot without a token is dead


class _Sample(Struct, frozen=True):
    """A message, or the reply to a query of ours."""

    key: str
    payload: bytes
    is_answer: bool = False


class _Token(Struct, frozen=True):
    """A liveliness token that appeared or vanished."""

    key: str
    shown: bool


class _Listed(Struct, frozen=True):
    """All tokens on a pattern have been told."""

    pattern: str | None
    """None: there may be nothing to wait for."""


_Raw = _Sample | zenoh.Query | _Token | _Listed


@dataclass(frozen=True, slots=True)
class _Declared:
    """What a process declares in its session: see `open_transport`."""

    session: Session
    hear: Sequence[str]
    answer: Sequence[str]
    alive: str | None


class ZenohTransport:
    """One process's session. Made by `open_transport`."""

    def __init__(self, declared: _Declared, watch: Collection[str]) -> None:
        self._declared = declared
        self._watches: dict[str, zenoh.Subscriber[None] | None] = dict.fromkeys(watch)
        """The subscribers by their patterns; None before it is declared."""
        self._unlisted: set[str] = set()
        self._opened = contextlib.ExitStack()
        """Ends the token, then the session."""
        self._session = self._opened.enter_context(
            _connected(declared.session, connect_s(declared.session.robots))
        )
        self._publishers: dict[str, zenoh.Publisher] = {}
        """Of the keys that are sent on often (rule 8)."""
        self._often = math.inf if declared.session.name == WORLD else OFTEN
        self._ask_timeout_s = ask_timeout_ms(declared.session.robots) / 1000.0
        self._deafness = Deafness(declared.alive)
        self._pulse_key, self._pulse_at_s = declared.session.keys.pulse(declared.session.name), 0.0
        self._traffic = Traffic()
        self._alarm = alarm(asyncio.get_running_loop())
        self._inbox: Inbox[_Raw] = Inbox(self._alarm.ring, capacity=INBOX_CAPACITY, bytes_max=INBOX_BYTES_MAX)

    @property
    def traffic(self) -> Traffic:
        """Messages sent and received so far, by key."""
        self._traffic.note_overflow(self._inbox.dropped_count)
        return self._traffic

    @property
    def router(self) -> str | None:
        """The unique name of the connected router; None while there is none."""
        return next(map(str, self._session.info.routers_zid()), None)

    def put(self, key: str, message: Message) -> None:
        """Send to all subscribers of the key; the message may be lost; never blocks."""
        number = self._traffic.send(key)
        self._send(key, encode(message, number, key), number)

    def _send(self, key: str, payload: bytes, number: int) -> None:
        try:
            if number < self._often:
                self._session.put(key, payload, congestion_control=DROP, allowed_destination=REMOTE)
                return
            if (publisher := self._publishers.get(key)) is None:
                publisher = self._publishers[key] = self._session.declare_publisher(
                    key, congestion_control=DROP, allowed_destination=REMOTE
                )
            publisher.put(payload)
        except zenoh.ZError:
            return  # the session is closed: the message is lost, like any other

    def ask(self, key: str, message: Message) -> None:
        """Query the key; the reply arrives as `Heard`, or is lost: then ask again."""
        with contextlib.suppress(zenoh.ZError):
            self._session.get(
                key,
                Callback(self._take_reply, indirect=False),
                payload=encode(message, 0, key),
                timeout=self._ask_timeout_s,
                congestion_control=DROP,
                allowed_destination=REMOTE,
            )

    async def arrivals(self, timeout_s: float | None) -> Sequence[Arrival]:
        """Wait for arrivals and return all of them; empty after the timeout."""
        await self._alarm.wait(0.0 if len(self._inbox) else timeout_s)
        raw = self._inbox.drain()  # nothing is awaited from here on: a call that is cancelled loses nothing
        if not raw:
            self._test_session(time.monotonic())
        arrivals = [arrival for each in raw if (arrival := self._arrived_as(each)) is not None]
        if (
            self._watches
            and self._deafness.is_alone
            and self._deafness.look(time.monotonic(), connected=self.router is not None)
        ):
            arrivals += self._reopen()
        return arrivals

    def declare(self) -> None:
        """Declare everything in the session; the token last."""
        callback = Callback(self.take, indirect=False)
        for key in self._declared.hear:
            self._session.declare_subscriber(key, callback, allowed_origin=zenoh.Locality.REMOTE)
        for key in self._declared.answer:
            self._session.declare_queryable(key, callback, allowed_origin=zenoh.Locality.REMOTE)
        for pattern in list(self._watches):
            self._watch(pattern)
        for pattern in list(self._unlisted):
            self._list(pattern)
        if (alive := self._declared.alive) is not None:
            self._opened.enter_context(self._session.liveliness().declare_token(alive))

    def watch(self, patterns: Collection[str]) -> None:
        """Watch the tokens on these patterns from now on, and no others; `Listed` follows."""
        with contextlib.suppress(zenoh.ZError):
            for pattern in [each for each in patterns if each not in self._watches]:
                self._watch(pattern)
                self._list(pattern)
            for pattern in [each for each in self._watches if each not in patterns]:
                if (subscriber := self._watches.pop(pattern)) is not None:
                    subscriber.undeclare()  # type: ignore[no-untyped-call]  # Zenoh gives it no type
        self._deafness.forget_others(patterns)
        self._unlisted &= self._watches.keys()
        if not self._unlisted:
            self._inbox.append(_Listed(None), 0)

    def _watch(self, pattern: str) -> None:
        callback = Callback(self.take_token, indirect=False)
        self._watches[pattern] = self._session.liveliness().declare_subscriber(
            pattern, callback, history=True
        )

    def _list(self, pattern: str) -> None:
        """Rule 7."""
        self._unlisted.add(pattern)
        end = Callback(self._take_listed, lambda: self._inbox.append(_Listed(pattern), 0), indirect=False)
        self._session.liveliness().get(pattern, end, timeout=LIST_TIMEOUT_S)

    def close(self) -> None:
        """Close the session (rule 2)."""
        self._opened.close()

    def _reopen(self) -> list[Vanished]:
        """Rule 6; returns the tokens that the old session saw: the new one tells those that are shown."""
        try:
            fresh = _connected(self._declared.session, 0.0)  # it blocks the event loop
        except UsageError:
            return []  # there is no router, or it has no time for us: try again later
        self.close()
        self._session = self._opened.enter_context(fresh)
        self._publishers.clear()
        self.declare()
        log.warning("%s is connected and sees nobody: its session is a new one", self._declared.session.name)
        return [Vanished(key) for key in self._deafness.forget()]

    def _test_session(self, now_s: float) -> None:
        """Rule 5: test the session from time to time."""
        if now_s >= self._pulse_at_s:
            self._pulse_at_s = now_s + PULSE_S
            self._send(self._pulse_key, b"", 0)

    def timestamp(self) -> str:
        """A new hybrid-logical-clock time stamp of this process."""
        return str(self._session.new_timestamp())

    def take(self, raw: zenoh.Sample | zenoh.Query) -> None:
        """Called in Zenoh's thread: a message or a query has arrived."""
        if isinstance(raw, zenoh.Query):
            carried = [each for each in (raw.payload, raw.attachment) if each is not None]
            self._inbox.append(raw, len(str(raw.selector)) + sum(map(len, carried)))  # kept whole, to reply
        else:
            self._take(raw)

    def _take(self, sample: zenoh.Sample, *, is_answer: bool = False) -> None:
        key, payload = str(sample.key_expr), sample.payload.to_bytes()
        self._inbox.append(_Sample(key, payload, is_answer), len(key) + len(payload))

    def take_token(self, sample: zenoh.Sample) -> None:
        """Called in Zenoh's thread: a liveliness token has appeared or vanished."""
        key = str(sample.key_expr)
        self._inbox.append(_Token(key, sample.kind == zenoh.SampleKind.PUT), len(key))

    def _take_listed(self, reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            self.take_token(reply.ok)

    def _take_reply(self, reply: zenoh.Reply) -> None:
        if reply.ok is not None:  # an error means a timeout: there is no reply
            self._take(reply.ok, is_answer=True)

    def _arrived_as(self, raw: _Raw) -> Arrival | None:
        """What has arrived; None: a token that is not watched, or a list while others are to come."""
        if isinstance(raw, _Listed):
            waited = raw.pattern is None or raw.pattern in self._unlisted
            self._unlisted -= {raw.pattern}
            return Listed() if waited and not self._unlisted else None
        key = str(raw.key_expr) if isinstance(raw, zenoh.Query) else raw.key
        if isinstance(raw, _Token) and not any(matches(pattern, key) for pattern in self._watches):
            return None
        try:
            _check_key(key)
            return self._read(raw, key)
        except MessageRefusedError as error:
            self._traffic.refuse(key[:KEY_LENGTH_MAX])
            return Refused(key[:KEY_LENGTH_MAX], str(error))

    def _read(self, raw: _Sample | zenoh.Query | _Token, key: str) -> Heard | Asked | Appeared | Vanished:
        """What has arrived on a key that may be ours.

        Raises:
            MessageRefusedError: the message is damaged.
        """
        if isinstance(raw, _Sample):
            number, message = decode(raw.payload, key)
            if raw.is_answer:
                return Heard(key, 0, message)
            self._traffic.receive(key, number)
            return Heard(key, number, message)
        if isinstance(raw, zenoh.Query):
            _, message = decode(raw.payload.to_bytes() if raw.payload else b"", key)
            return Asked(key, message, lambda answer: _reply(raw, key, answer))
        self._deafness.see(key, shown=raw.shown)
        return Appeared(key) if raw.shown else Vanished(key)


@contextlib.contextmanager
def open_transport(
    session: Session, *, hear: Sequence[str], answer: Sequence[str], alive: str | None, watch: Collection[str]
) -> Iterator[ZenohTransport]:
    """A transport that subscribes to `hear`, answers queries on `answer`, and watches tokens on `watch`.

    The token `alive` is declared last, so a process that sees it knows that the rest is in place. Enter the
    context in the event loop that will process the arrivals.

    Raises:
        UsageError: no router admits us.
        SessionLostError: Zenoh has panicked, here or in one of its own threads before.
    """
    with _panic_is_loss():
        transport = ZenohTransport(_Declared(session, hear, answer, alive), watch)
        with contextlib.closing(transport):
            transport.declare()
            yield transport


@contextlib.contextmanager
def _panic_is_loss() -> Iterator[None]:
    try:
        yield
    except BaseException as error:  # a panic is not an Exception, and its class cannot be imported
        if type(error).__name__ != "PanicException":
            raise
        raise SessionLostError(f"Zenoh has panicked, and the session is lost: {error}") from error


def _connected(session: Session, patience_s: float) -> zenoh.Session:
    """A session; each try is a new one, since one that is half open is refused any other link."""
    until_s = time.monotonic() + patience_s
    while True:
        try:
            return open_session(session)
        except zenoh.ZError as error:
            if time.monotonic() >= until_s:
                raise UsageError(session.no_link) from error
        time.sleep(RETRY_S)


def open_session(session: Session) -> zenoh.Session:
    """A bare session. The first one decides how many threads Zenoh has in this process.

    Raises:
        zenoh.ZError: no router admits us.
    """
    os.environ.setdefault("ZENOH_RUNTIME", CLIENT_THREADS)
    settings = msgspec.json.encode(client_settings(session)).decode()
    return zenoh.open(zenoh.Config.from_json5(settings))


def _check_key(key: str) -> None:
    if len(key) > KEY_LENGTH_MAX:
        raise MessageRefusedError(f"its key has {len(key)} characters, more than {KEY_LENGTH_MAX}")
    if "*" in key:
        raise MessageRefusedError("its key is a pattern, so it names no sender")


def _reply(query: zenoh.Query, key: str, message: Message) -> None:
    with query, contextlib.suppress(zenoh.ZError):  # the asking process may have given up, or the router
        query.reply(key, encode(message, 0, key))  # sent with the congestion control of the query
