"""On a damaged wire, each message arrives as it was sent or is refused, and a fleet still arrives."""

import asyncio
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path

import pytest

from protocol.errors import SessionLostError
from protocol.keys import WORLD
from protocol.network.session import unix_socket_endpoint, write_sessions
from protocol.network.transport import Appeared, Arrival, Heard, Refused
from protocol.network.zenoh_transport import ZenohTransport
from protocol.run_settings import Settings
from protocol.wire.messages import Message
from tests.support.deadline import DEADLINE_S
from tests.support.long import long
from tests.support.processes.fleets import Fleet, wait_until
from tests.support.processes.parts import Parts, said
from tests.support.processes.proxy import Faults, Proxy, Way, proxy_aside
from tests.support.processes.wire import (
    KEYS,
    TOKEN,
    drive,
    next_arrivals,
    odometry,
    python,
    robot_transport,
    world_transport,
)
from world.scenario.scenario import load

ROBOTS = ("r1", "r2", "r3")
WIRES_MAX = 5  # Zenoh panicked in 5 of about 200 conversations
UNHEARD_OF = Faults(forged=b"\x19\x01")  # an unexpected end of an interest: it makes a Zenoh client panic
# 17 s of a run without faults
GROVE, SETTINGS = load("grove", robots=len(ROBOTS)), Settings(seed=1, speed=2.0)
ROUND_S = 0.005  # time for sent messages to arrive
ROUNDS_MAX = 2000


def behind(folder: Path) -> tuple[str, str]:
    """Where a router behind a proxy listens, as an endpoint and as a path: a free port may not stay free."""
    endpoint = unix_socket_endpoint(folder)
    return endpoint, endpoint.partition("/")[2]


@contextmanager
def damaged_wire(seed: int) -> Iterator[tuple[Path, Proxy]]:
    """Sessions that reach their router through a proxy."""
    folder = Path(tempfile.mkdtemp(prefix="clew"))
    inner, path = behind(folder)
    try:
        with proxy_aside(path, seed=seed) as (between, port):
            found = f"tcp/127.0.0.1:{port}"
            write_sessions(folder, fleet=KEYS.fleet, run=KEYS.run, robots=len(ROBOTS), endpoints=[found])
            options = ["--sessions", str(folder), "--lifeline", "--listen", inner]
            with python("-m", "protocol", *options) as router:
                assert router.stdout is not None
                assert router.stdout.readline().startswith("ready ")
                yield folder, between
    finally:
        shutil.rmtree(folder)


@contextmanager
def fleet_behind_proxy(fleet: Fleet) -> Iterator[tuple[subprocess.Popen[str], Proxy]]:
    """The world process of a whole fleet that reaches its router through a proxy."""
    inner, path = behind(fleet.temporary)
    with (
        proxy_aside(path, seed=1) as (between, port),
        Parts(fleet, len(ROBOTS), GROVE, SETTINGS, f"tcp/127.0.0.1:{port}", inner).started() as world,
    ):
        yield world, between


@dataclass(slots=True)
class Talk:
    """The messages that were sent, and those that arrived."""

    said: dict[tuple[str, int], Message] = field(default_factory=dict)
    heard: list[Heard] = field(default_factory=list)
    refused: list[Refused] = field(default_factory=list)

    def say(self, sender: ZenohTransport, key: str, message: Message) -> None:
        sender.put(key, message)
        self.said[key, sender.traffic.sent[key]] = message

    def hear(self, arrivals: Sequence[Arrival]) -> None:
        self.heard += [each for each in arrivals if isinstance(each, Heard)]
        self.refused += [each for each in arrivals if isinstance(each, Refused)]

    @property
    def corrupt(self) -> list[Heard]:
        """The received messages that nobody sent."""
        return [each for each in self.heard if self.said.get((each.key, each.number)) != each.message]


async def converse(talk: Talk, folder: Path, between: Proxy, faults: Faults, *, until_refused: int) -> None:
    """Send different messages on all kinds of keys until enough have been refused."""
    async with asyncio.timeout(DEADLINE_S):
        with ExitStack() as stack:
            world = stack.enter_context(world_transport(folder))
            robots = [stack.enter_context(robot_transport(folder, name)) for name in ROBOTS]
            await next_arrivals(world, len(ROBOTS))
            for way in Way:
                between.faults[way] = faults
            number = 0
            while len(talk.refused) < until_refused:
                for name, robot in zip(ROBOTS, robots, strict=True):
                    number += 1
                    talk.say(world, KEYS.odometry(name), odometry(float(number)))
                    for key in (KEYS.drive(name), KEYS.fence(name)):
                        talk.say(robot, key, drive(number))
                for each in (world, *robots):
                    talk.hear(await each.arrivals(ROUND_S))
            for way in Way:
                between.faults[way] = Faults()


@pytest.mark.parametrize(
    ("faults", "until_refused"),
    [(Faults(flip_probability=0.05), 200), *long([(Faults(truncate_probability=0.02), 20)])],
    ids=["flips", "cuts"],
)
async def test_messages_received_on_a_damaged_wire_were_sent(faults: Faults, until_refused: int) -> None:
    heard, refused = 0, 0
    for seed in range(1, WIRES_MAX + 1):
        talk = Talk()
        with damaged_wire(seed) as (folder, between), suppress(SessionLostError):
            await converse(talk, folder, between, faults, until_refused=until_refused - refused)
        assert talk.corrupt == []
        heard, refused = heard + len(talk.heard), refused + len(talk.refused)
        if refused >= until_refused:
            break
    assert heard > refused >= until_refused, "a session was lost every time"


async def test_a_session_in_which_zenoh_panics_is_lost() -> None:
    with damaged_wire(seed=1) as (folder, between):
        with pytest.raises(SessionLostError, match="Zenoh has panicked"):
            await converse(Talk(), folder, between, UNHEARD_OF, until_refused=1)
        assert between.faults[Way.UP] == UNHEARD_OF  # it was lost after this, not at the start


async def stay_silent(folder: Path, between: Proxy, rounds: Iterator[int]) -> None:
    """A robot that only listens and then receives an illegal message."""
    with world_transport(folder) as world, robot_transport(folder, "r1") as robot:
        await next_arrivals(world)
        between.faults[Way.DOWN] = UNHEARD_OF
        world.put(KEYS.odometry("r1"), odometry(0.0))
        try:
            while next(rounds) < ROUNDS_MAX:
                await robot.arrivals(ROUND_S)
        finally:
            between.faults[Way.DOWN] = Faults()  # so that the world's session ends normally


async def test_a_silent_client_detects_that_its_session_is_lost() -> None:
    rounds = count()
    with damaged_wire(seed=1) as (folder, between), pytest.raises(SessionLostError):
        await stay_silent(folder, between, rounds)
    assert next(rounds) < ROUNDS_MAX, "it noticed only when it closed"


async def test_sessions_whose_new_links_are_deaf_are_opened_anew_and_hear_each_other_again() -> None:
    with (
        damaged_wire(seed=1) as (folder, between),
        world_transport(folder, alive=KEYS.alive(WORLD, TOKEN)) as world,
        robot_transport(folder, "r1", watch=[KEYS.tokens_of("*")]) as robot,
    ):
        both, numbers = (world, robot), count(1)

        async def talk_until(enough: Callable[[Sequence[Arrival]], bool], faults: Faults) -> list[Arrival]:
            """Send both ways until what has arrived is enough."""
            between.faults.update(dict.fromkeys(Way, faults))
            arrived: list[Arrival] = []
            async with asyncio.timeout(DEADLINE_S):
                while not enough(arrived):
                    robot.put(KEYS.drive("r1"), drive(next(numbers)))
                    world.put(KEYS.odometry("r1"), odometry(0.0))
                    for each in both:
                        arrived += await each.arrivals(ROUND_S)
            return arrived

        def both_heard(arrived: Sequence[Arrival]) -> bool:
            return {KEYS.drive("r1"), KEYS.odometry("r1")} <= {
                each.key for each in arrived if isinstance(each, Heard)
            }

        await talk_until(both_heard, Faults())
        await talk_until(lambda _: world.router is robot.router is None, Faults(reset_probability=1.0))
        await talk_until(
            lambda _: None not in (world.router, robot.router),
            Faults(frames_lost=True),  # as if Zenoh had given the link up while it was opened
        )
        again = await talk_until(both_heard, Faults())
        heard = [each for each in again if isinstance(each, Heard)]
        assert min(each.number for each in heard) > 1, "message numbers go on"
        assert Appeared(KEYS.alive("r1", TOKEN)) in again, "it is the same process"


def test_world_and_robots_report_a_lost_session_and_end(fleet: Fleet) -> None:
    with fleet_behind_proxy(fleet) as (world, between):
        fleet.wait_for("step.planned")
        between.faults[Way.DOWN] = UNHEARD_OF
        assert world.wait(DEADLINE_S) == -signal.SIGABRT  # a crash: the launcher would restart it
        # At the end of the context robots would be told to end, which one that is late would do instead.
        parts = ["world", *(f"robot {number}" for number in range(1, len(ROBOTS) + 1))]
        reports = [f"{part}: Zenoh has panicked, and the session is lost" for part in parts]
        wait_until(lambda: all(report in said(fleet) for report in reports) or None)


def test_fleet_arrives_over_a_slow_wire_that_damaged_messages_for_a_while(fleet: Fleet) -> None:
    slow = Faults(delay_s=0.05, jitter_s=0.02)
    # A flipped bit in Zenoh's own bytes may end a session or silence a link for good (docs/chaos.md).
    damaged = replace(slow, flip_probability=0.02, only_seals=True)
    with fleet_behind_proxy(fleet) as (world, between):
        fleet.wait_for("step.planned")
        for way in Way:
            between.faults[way] = damaged
        fleet.wait_for("message.refused")
        for way in Way:
            between.faults[way] = slow
        world.wait(DEADLINE_S)
    verdict = fleet.verdict()
    assert verdict["violations"] == 0, said(fleet)
    assert (verdict["robots_arrived"], verdict["goal_reached"]) == (len(ROBOTS), True), said(fleet)
    assert verdict["events"]["missing"] == 0
    messages = verdict["messages"]
    assert messages["left_out"] == []
    assert messages["sent"] == messages["received"] + messages["refused"] + messages["unaccounted"]
