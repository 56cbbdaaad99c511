"""Attacks over the real router, by a client admitted as r2 and by clients without admission. None succeeds.

Each attack is followed by a permitted control message on the same link. Links keep their order, so an attack
that got through would have arrived before the control message. Each forgery is repeated through a router
without rules, where it arrives: this shows that the tests would see a successful attack.
"""

import contextlib
import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from threading import Event

import msgspec
import pytest
import zenoh
from zenoh.handlers import Callback

from protocol.keys import WORLD, Keys
from protocol.network.access import user_name
from protocol.network.session import read_session, unix_socket_endpoint, write_sessions
from protocol.network.settings import client_settings
from protocol.network.transport import Arrival, Asked, Heard, Refused
from protocol.network.zenoh_transport import KEY_LENGTH_MAX, ZenohTransport
from protocol.wire.codec import SCHEMA_VERSION, SIZE_MAX_BYTES, encode, packed, sealed
from protocol.wire.messages import Ask
from tests.support.deadline import DEADLINE_S
from tests.support.processes.wire import (
    KEYS,
    arrivals_besides,
    drive,
    fleet,
    next_arrivals,
    odometry,
    robot_transport,
    router,
    session_folder,
    world_transport,
)

FORGED_KEYS = [
    KEYS.link("r1", "r3"),
    KEYS.link("r3", "r1"),
    KEYS.link("*", "r1"),
    KEYS.link("r$*", "r1"),
    KEYS.link("r1", "*"),
    KEYS.drive("r1"),
    KEYS.drive("*"),
    KEYS.odometry("r1"),
    KEYS.odometry("r2"),
    KEYS.odometry("*"),
    KEYS.view("r1", "r3"),
    KEYS.view("r3", "r1"),
    KEYS.view("*", "r1"),
    KEYS.view("r1", "*"),
    KEYS.fence("r1"),
    KEYS.fence("*"),
    KEYS.fence("0"),  # the operator's
    KEYS.log("r1"),
    KEYS.log("*"),
    KEYS.log("world"),
    KEYS.logged("r1"),
    KEYS.logged("*"),
    f"{KEYS.root}/**",
    "**",
]
UNHEARD_KEYS = [KEYS.odometry("r2"), KEYS.log("world")]  # r1, r3 and the world subscribe to neither
FOREIGN_KEYS = [
    "**",
    f"{KEYS.root}/**",
    KEYS.link("*", "*"),
    KEYS.link("r1", "*"),
    KEYS.link("r1", "r3"),
    KEYS.view("*", "*"),
    KEYS.view("r1", "*"),
    KEYS.view("r1", "r3"),
    KEYS.drive("*"),
    KEYS.drive("r1"),
    KEYS.fence("*"),
    KEYS.fence("r1"),
    KEYS.odometry("*"),
    KEYS.odometry("r1"),
    KEYS.log("*"),
    KEYS.log("r1"),
    KEYS.logged("*"),
    KEYS.logged("r1"),
]
FORGED_TO_SOMEBODY = [key for key in FORGED_KEYS if key not in UNHEARD_KEYS]


def forged(key: str) -> bytes:
    """A message that a robot or the world would accept as an order, on any key it subscribes to."""
    return encode(drive(666), 1, key)


@pytest.fixture(scope="module")
def guarded() -> Iterator[Path]:
    """Sessions of a run whose router has our access rules."""
    with session_folder() as folder, router(folder):
        yield folder


@pytest.fixture(scope="module")
def unguarded() -> Iterator[Path]:
    """Sessions of a run whose router has no access rules, like a stock router run by the user."""
    with session_folder() as folder:
        endpoint = unix_socket_endpoint(folder)
        write_sessions(
            folder, fleet=KEYS.fleet, run=KEYS.run, robots=3, endpoints=[endpoint], passwords=False
        )
        settings = {
            "mode": "router",
            "listen": {"endpoints": [endpoint]},
            "scouting": {"multicast": {"enabled": False}},
        }
        with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))):
            yield folder


@contextlib.contextmanager
def intruder(
    folder: Path, name: str = "r2", changes: Mapping[str, str | tuple[str, ...] | None] | None = None
) -> Iterator[zenoh.Session]:
    """A bare Zenoh session with a robot's credentials, or with others. It bypasses our transport code."""
    settings = client_settings(
        msgspec.structs.replace(read_session(folder / f"{name}.json"), **(changes or {}))
    )
    settings["connect"]["timeout_ms"] = 0
    settings["transport"]["link"]["rx"]["max_message_size"] = 2**30
    with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
        yield session


def sets(event: Event) -> Callable[[object], None]:
    """A callback that only sets the event."""
    callback: Callback[object] = Callback(lambda _: event.set(), indirect=False)
    return callback


def adds_key_to(keys: set[str]) -> Callable[[zenoh.Sample], None]:
    """A callback that only adds the sample's key to the set."""
    callback: Callback[zenoh.Sample] = Callback(lambda s: keys.add(str(s.key_expr)), indirect=False)
    return callback


async def heard_after_control(
    attacker: zenoh.Session, world: ZenohTransport, *robots: ZenohTransport
) -> list[Arrival]:
    """Everything that the world and the robots received before the attacker's permitted control messages."""
    heard: list[Arrival] = []
    controls = [KEYS.drive("r2"), KEYS.link("r2", "r1"), KEYS.link("r2", "r3")]
    for key, receiver in zip(controls, (world, *robots), strict=True):
        # Behind a large message one that may be dropped is dropped now and then, and never comes.
        attacker.put(key, encode(drive(0), 0, key), congestion_control=zenoh.CongestionControl.BLOCK)
        heard += await arrivals_besides(receiver, key)
    return heard


@pytest.mark.parametrize("key", FORGED_KEYS)
async def test_forged_messages_reach_nobody(guarded: Path, key: str) -> None:
    async with fleet(guarded, "r1", "r3") as (world, *robots):
        with intruder(guarded) as attacker:
            attacker.put(key, forged(key))
            attacker.delete(key)
            attacker.declare_publisher(key).put(forged(key))
            assert await heard_after_control(attacker, world, *robots) == []


@pytest.mark.parametrize("key", FORGED_TO_SOMEBODY)
async def test_the_same_forgery_gets_through_a_router_without_rules(unguarded: Path, key: str) -> None:
    async with fleet(unguarded, "r1", "r3") as (world, *robots):
        with intruder(unguarded) as attacker:
            attacker.put(key, forged(key))
            assert await heard_after_control(attacker, world, *robots) != []


async def overheard(folder: Path, key: str) -> set[str]:
    """The keys on which r2 receives samples when it subscribes to this key, except those it may receive."""
    heard: set[str] = set()
    async with fleet(folder, "r1", "r3") as (world, robot, _):
        with intruder(folder) as attacker:
            attacker.declare_subscriber(key, adds_key_to(heard))
            control = Event()
            lawful = KEYS.link("r1", "r2")
            attacker.declare_subscriber(lawful, sets(control))
            attacker.put(KEYS.drive("r2"), encode(drive(0), 1, KEYS.drive("r2")))
            await next_arrivals(world)  # so the router has the attacker's subscriptions
            links = (KEYS.link("r1", "r3"), KEYS.view("r1", "r3"))
            for said in (*links, KEYS.drive("r1"), KEYS.fence("r1"), KEYS.log("r1")):
                robot.put(said, drive(1))
            for told in (KEYS.odometry("r1"), KEYS.logged("r1")):
                world.put(told, odometry(0.0))
            await next_arrivals(robot, 2)
            robot.put(lawful, drive(1))
            assert control.wait(DEADLINE_S)
    # Within a session, a sample goes to every matching subscriber, even the session's own samples.
    return heard - {lawful, KEYS.drive("r2")}


@pytest.mark.parametrize("key", FOREIGN_KEYS)
async def test_a_foreign_subscription_hears_nothing(guarded: Path, key: str) -> None:
    assert await overheard(guarded, key) == set()


@pytest.mark.parametrize("key", FOREIGN_KEYS)
async def test_the_same_subscription_hears_through_a_router_without_rules(unguarded: Path, key: str) -> None:
    assert await overheard(unguarded, key) != set()


async def tokens_seen(folder: Path) -> list[Arrival]:
    """What the world sees when r2 declares the tokens of others, between two of its own."""
    first, last = KEYS.alive("r2", "1"), KEYS.alive("r2", "2")
    foreign = [KEYS.alive("r1", "9"), KEYS.alive("*", "9"), KEYS.alive("world", "9")]
    with world_transport(folder) as world, intruder(folder) as attacker:
        tokens = [attacker.liveliness().declare_token(first)]
        await arrivals_besides(world, first)  # tokens that exist at the first query may come in any order
        tokens += [attacker.liveliness().declare_token(key) for key in (*foreign, last)]
        seen = await arrivals_besides(world, last)
        assert len(tokens) == 5  # a token lives as long as there is a reference to it
    return seen


async def test_nobody_sees_a_foreign_token(guarded: Path) -> None:
    assert await tokens_seen(guarded) == []


async def test_the_same_token_is_seen_through_a_router_without_rules(unguarded: Path) -> None:
    assert await tokens_seen(unguarded) != []


async def tokens_watched(folder: Path, key: str) -> set[str]:
    """The tokens that r2 sees when it watches this key."""
    seen: set[str] = set()
    async with fleet(folder, "r1") as (world, _):
        with intruder(folder) as attacker:
            attacker.liveliness().declare_subscriber(key, adds_key_to(seen), history=True)
            with robot_transport(folder, "r3") as robot:
                await next_arrivals(world)
                control = Event()
                attacker.declare_subscriber(KEYS.link("*", "r2"), sets(control))
                attacker.put(KEYS.drive("r2"), encode(drive(0), 1, KEYS.drive("r2")))
                await next_arrivals(world)
                robot.put(KEYS.link("r3", "r2"), drive(1))
                assert control.wait(DEADLINE_S)
    return seen


async def test_robots_see_the_tokens_of_living_robots(guarded: Path) -> None:
    tokens = {KEYS.alive("r1", "1"), KEYS.alive("r3", "1")}
    assert await tokens_watched(guarded, KEYS.alive("*", "*")) == tokens


async def test_a_watch_on_more_than_tokens_sees_nothing(guarded: Path) -> None:
    assert await tokens_watched(guarded, "**") == set()


async def test_the_same_watch_sees_tokens_through_a_router_without_rules(unguarded: Path) -> None:
    assert await tokens_watched(unguarded, "**") != set()


@pytest.mark.parametrize("key", [KEYS.scan("r1"), KEYS.scan("*"), "**", f"{KEYS.root}/**"])
@pytest.mark.parametrize("rules", ["guarded", "unguarded"])
async def test_a_foreign_query_reaches_the_world_only_without_rules(
    request: pytest.FixtureRequest, rules: str, key: str
) -> None:
    folder = request.getfixturevalue(rules)
    async with fleet(folder, "r1") as (world, _):
        with intruder(folder) as attacker:
            for asked in (key, KEYS.scan("r2")):
                attacker.get(asked, sets(Event()), payload=encode(Ask(), 0, asked))
            foreign = await arrivals_besides(world, KEYS.scan("r2"))
    assert (foreign != []) == (rules == "unguarded")


@pytest.mark.parametrize("rules", ["guarded", "unguarded"])
async def test_a_robot_can_answer_for_the_world_only_without_rules(
    request: pytest.FixtureRequest, rules: str
) -> None:
    folder = request.getfixturevalue(rules)
    asked = Event()
    async with fleet(folder, "r1") as (world, robot):
        with intruder(folder) as attacker:
            for key in (KEYS.scan("r1"), KEYS.mission(), "**"):
                attacker.declare_queryable(key, sets(asked), complete=True)
            attacker.put(KEYS.drive("r2"), encode(drive(0), 1, KEYS.drive("r2")))
            await next_arrivals(world)
            robot.ask(KEYS.mission(), Ask())
            if rules == "unguarded":
                assert asked.wait(DEADLINE_S)
            else:
                (question,) = await next_arrivals(world)
                assert isinstance(question, Asked)
                question.answer(odometry(1.0))
                assert await next_arrivals(robot) == [Heard(KEYS.mission(), 0, odometry(1.0))]
                assert not asked.is_set()


@pytest.mark.parametrize("padding_bytes", [0, SIZE_MAX_BYTES, 3 * SIZE_MAX_BYTES // 2, 10_000_000])
async def test_nobody_receives_a_message_over_the_size_limit(guarded: Path, padding_bytes: int) -> None:
    lawful_but_for_its_size = {
        "v": SCHEMA_VERSION,
        "n": 1,
        "m": {"type": "ask", "padding": "x" * padding_bytes},
    }
    async with fleet(guarded, "r1", "r3") as (world, *robots):
        with intruder(guarded) as attacker:
            key = KEYS.view("r2", "r1")
            payload = sealed(packed(lawful_but_for_its_size), key)
            attacker.put(key, payload, congestion_control=zenoh.CongestionControl.BLOCK)
            heard = await heard_after_control(attacker, world, *robots)
    understood = [each for each in heard if not isinstance(each, Refused)]
    assert (understood == []) == (padding_bytes > 0)
    assert (heard == []) == (padding_bytes > 2 * SIZE_MAX_BYTES)  # the router does not forward it


async def test_a_message_that_breaks_the_protocol_is_refused_with_its_key_and_counted(guarded: Path) -> None:
    keys = [KEYS.view("r2", "r1"), KEYS.view("r2", "r3")]
    async with fleet(guarded, "r1", "r3") as (world, *robots):
        with intruder(guarded) as attacker:
            for key in keys:
                attacker.put(key, b"junk")
            heard = await heard_after_control(attacker, world, *robots)
    refused = [each.key for each in heard if isinstance(each, Refused)]
    assert refused == keys
    assert [each.traffic.refused.total() for each in (world, *robots)] == [0, 1, 1]


async def test_a_key_that_is_a_pattern_or_too_long_names_no_sender_and_is_refused(unguarded: Path) -> None:
    async with fleet(unguarded, "r1", "r3") as (world, *robots):
        with intruder(unguarded) as attacker:
            attacker.put(KEYS.link("*", "r1"), forged(KEYS.link("*", "r1")))
            attacker.put(KEYS.link("x" * 300, "r1"), forged(KEYS.link("x" * 300, "r1")))
            attacker.put(KEYS.link("r2", "*"), forged(KEYS.link("r2", "*")))
            heard = await heard_after_control(attacker, world, *robots)
    assert [type(each) for each in heard] == [Refused] * 4
    assert max(len(each.key) for each in heard) == KEY_LENGTH_MAX


WRONG = {
    "wrong password": {"password": "wrong"},
    "another's name": {"user": user_name(KEYS, "r1")},
    "the world's name": {"user": user_name(KEYS, WORLD)},
    "unknown name": {"user": user_name(KEYS, "r9")},
    "no password": {"user": None, "password": None},
}


@pytest.mark.parametrize("changes", WRONG.values(), ids=WRONG.keys())
def test_a_client_with_wrong_credentials_is_not_admitted(
    guarded: Path, changes: dict[str, str | tuple[str, ...] | None]
) -> None:
    with pytest.raises(zenoh.ZError, match="Unable to connect"), intruder(guarded, changes=changes):
        pass
    with intruder(guarded) as admitted:
        assert len(admitted.info.links()) == 1


def test_a_robot_of_another_run_is_not_admitted(guarded: Path) -> None:
    endpoints = read_session(guarded / "r2.json").endpoints
    with session_folder(run="other") as other, router(other):
        with (
            pytest.raises(zenoh.ZError, match="Unable to connect"),
            intruder(other, changes={"endpoints": endpoints}),
        ):
            pass
        with intruder(other) as admitted:
            assert len(admitted.info.links()) == 1


async def test_nobody_receives_messages_under_another_runs_keys(guarded: Path) -> None:
    other_run = Keys(KEYS.fleet, "other")
    async with fleet(guarded, "r1", "r3") as (world, *robots):
        with intruder(guarded, "world") as spy, intruder(guarded) as attacker:
            spied = Event()
            spy.declare_subscriber(f"{other_run.root}/**", sets(spied))
            spy.put(KEYS.odometry("r1"), encode(odometry(0.0), 1, KEYS.odometry("r1")))
            await next_arrivals(robots[0])  # so the router has the spy's subscriptions
            control = Event()
            spy.declare_subscriber(KEYS.drive("r2"), sets(control))
            attacker.put(other_run.link("r2", "r1"), forged(other_run.link("r2", "r1")))
            assert await heard_after_control(attacker, world, *robots) == []
            attacker.put(KEYS.drive("r2"), encode(drive(0), 2, KEYS.drive("r2")))
            assert control.wait(DEADLINE_S)
            assert not spied.is_set()
