"""The relays of a chain, each a process with a session of its own: Clew's whole stack, and two bare ones.

Rule 1: all relays have the same sessions, keys, router and access rules. The bare ones forward the bytes that
        they get; `asyncio` does so in its event loop, which gets them by a queue, and `callback` in Zenoh's
        thread.
Rule 2: the whole stack is the shell of a robot, with its journal, and a core of the strand.
Rule 3: the last robot tells the time of its reaction: when it acknowledges the news to the robot ahead. A
        bare relay does so where it would forward.
Rule 4: a relay ends when it is killed, or when the process that forked it ends.
"""

import asyncio
import ctypes
import os
import signal
import struct
import time
from collections.abc import Callable
from enum import StrEnum
from pathlib import Path

import zenoh
from zenoh.handlers import Callback

from agents.process.hearing import heard
from agents.process.journal import Head, open_journal
from agents.process.shell import Shell
from agents.process.victim import Victim
from clew.bench.hop.strand import Strand
from protocol.keys import robot_name
from protocol.network.around import AroundTransport
from protocol.network.faulty_transport import Conditions
from protocol.network.inbox import OneTaskLoop
from protocol.network.session import Session, read_session
from protocol.network.transport import Transport
from protocol.network.zenoh_transport import open_session, open_transport
from protocol.wire.codec import encode
from protocol.wire.messages import BehindState, Message

INCARNATION = "hop"
PR_SET_PDEATHSIG = 1  # of Linux: prctl(2)
REACTION = struct.Struct(
    "=qq"
)  # number of the news, and when: ns of the monotonic clock, one for all processes
NUMBER = struct.Struct("=q")
SAID_BEFORE = 1000  # more messages than a strand needs to form: numbers of links go on from the rehearsal


Say = Callable[[], int]
"""Puts the leader's next news; returns its number."""


class Relay(StrEnum):
    """How a robot passes the news on."""

    STACK = "stack"
    ASYNCIO = "asyncio"
    CALLBACK = "callback"


class LastTransport(AroundTransport):
    """The transport of the last robot: it tells when the robot acknowledges news (rule 3)."""

    def __init__(self, inner: Transport, told: int) -> None:
        super().__init__(inner)
        self._told = told

    def put(self, key: str, message: Message) -> None:
        """Send, and tell the time first if it is the acknowledgement."""
        if isinstance(message, BehindState):
            os.write(self._told, REACTION.pack(message.vertices, time.monotonic_ns()))
        super().put(key, message)


def relay(kind: Relay, robot: int, strand: Strand, folder: Path, told: int) -> None:
    """Be one robot of the chain, until this process is killed (rule 4)."""
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    session = read_session(folder / f"{robot_name(robot)}.json")
    match kind:
        case Relay.STACK:
            with asyncio.Runner(loop_factory=OneTaskLoop) as runner:  # as the host of robots does
                runner.run(_stack(robot, session, strand, folder, told))
        case Relay.ASYNCIO:
            asyncio.run(_asyncio(robot, session, strand, told))
        case Relay.CALLBACK:
            with open_session(session) as opened:
                forward = _forward(opened, robot, session, strand, told)
                _subscribe(opened, session, lambda sample: forward(sample.payload.to_bytes()))
                while True:
                    time.sleep(3600.0)


async def _stack(robot: int, session: Session, strand: Strand, folder: Path, told: int) -> None:
    """Rule 2."""
    keys, name, conditions = session.keys, session.name, Conditions()
    alive = keys.alive(name, INCARNATION)
    victim = Victim(robot, folder, conditions, again=False)
    with open_transport(session, hear=heard(keys, name), answer=[], alive=alive, watch=[]) as opened:
        for neighbour in (robot - 1, robot + 1):
            go_on(opened, keys.link(name, robot_name(neighbour)))
        is_last = robot == len(strand.cores)
        transport = LastTransport(opened, told) if is_last else opened
        shell = Shell(robot, session, transport, INCARNATION, conditions=conditions, victim=victim)
        head = Head(robot=robot, incarnation=INCARNATION, mission=strand.mission, life=1)
        await shell.run(strand.cores[robot], open_journal(folder / f"inputs-{os.getpid()}", head))


def go_on(transport: Transport, key: str) -> None:
    """Number messages on this key higher than those of the rehearsal."""
    for _ in range(SAID_BEFORE):
        transport.traffic.send(key)


async def _asyncio(robot: int, session: Session, strand: Strand, told: int) -> None:
    loop = asyncio.get_running_loop()
    queue: asyncio.Queue[bytes] = asyncio.Queue()

    def take(sample: zenoh.Sample) -> None:
        loop.call_soon_threadsafe(queue.put_nowait, sample.payload.to_bytes())

    with open_session(session) as opened:
        forward = _forward(opened, robot, session, strand, told)
        _subscribe(opened, session, take)
        while True:
            forward(await queue.get())


def _subscribe(opened: zenoh.Session, session: Session, take: Callable[[zenoh.Sample], None]) -> None:
    """Hear what the robot ahead sends, in Zenoh's own thread."""
    key = session.keys.link("*", session.name)
    opened.declare_subscriber(key, Callback(take, indirect=False), allowed_origin=zenoh.Locality.REMOTE)


def _forward(
    opened: zenoh.Session, robot: int, session: Session, strand: Strand, told: int
) -> Callable[[bytes], None]:
    """What a bare relay does with the bytes that it gets."""
    if robot == len(strand.cores):
        return lambda payload: _tell(told, payload)
    key = session.keys.link(session.name, robot_name(robot + 1))
    return lambda payload: put(opened, key, payload)


def _tell(told: int, payload: bytes) -> None:
    (number,) = NUMBER.unpack_from(payload)
    os.write(told, REACTION.pack(number, time.monotonic_ns()))


def put(opened: zenoh.Session, key: str, payload: bytes) -> None:
    """As the transport of a robot sends."""
    opened.put(
        key,
        payload,
        congestion_control=zenoh.CongestionControl.DROP,
        allowed_destination=zenoh.Locality.REMOTE,
    )


async def lead(kind: Relay, strand: Strand, folder: Path, probe: Callable[[Say], None]) -> None:
    """Be the leader: `probe` gets the function that puts the next news."""
    session = read_session(folder / f"{robot_name(1)}.json")
    key = session.keys.link(session.name, robot_name(2))
    if kind is Relay.STACK:
        with open_transport(session, hear=[], answer=[], alive=None, watch=[]) as transport:
            go_on(transport, key)

            def say() -> int:
                news = strand.news()
                transport.put(key, news)
                return news.vertices

            probe(say)
        return
    size = len(encode(strand.news(), SAID_BEFORE, key))
    with open_session(session) as opened:
        numbers = iter(range(1, 1 << 30))

        def send() -> int:
            number = next(numbers)
            put(opened, key, NUMBER.pack(number).ljust(size, b"."))
            return number

        probe(send)
