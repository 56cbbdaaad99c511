"""The transport with fault injection, over one with arrivals from the test."""

import asyncio
from collections.abc import Collection, Sequence

from protocol.faults.plan import Plan
from protocol.faults.rules import Corrupt, Delay, Drop, Duplicate, Partition, Rule
from protocol.network.faulty_transport import Conditions, FaultyTransport
from protocol.network.traffic import Traffic
from protocol.network.transport import Appeared, Arrival, Asked, Heard, Listed, Refused, Vanished
from protocol.timeline import FaultInjected
from protocol.wire.messages import Ask, Faults, Message
from tests.support.deadline import DEADLINE_S
from tests.support.processes.wire import KEYS, drive, odometry

DRIVE = KEYS.drive("r1")
FAST = 1000.0  # simulated seconds per second: delays take no time


class Inner:
    """A network of the test: all its arrivals are there at once, then there are none for a moment."""

    router: str | None = "a"

    def __init__(self, *bursts: Sequence[Arrival]) -> None:
        self.traffic = Traffic()
        self.bursts = list(bursts)
        self.put_keys: list[str] = []

    def put(self, key: str, message: Message) -> None:  # noqa: ARG002 - the port's
        self.put_keys.append(key)

    def ask(self, key: str, message: Message) -> None:
        raise NotImplementedError

    def timestamp(self) -> str:
        return ""

    def watch(self, patterns: Collection[str]) -> None:
        self.watched = list(patterns)
        self.bursts.insert(0, [Listed()])

    async def arrivals(self, timeout_s: float | None) -> Sequence[Arrival]:
        if not self.bursts:
            await asyncio.sleep(timeout_s if timeout_s is not None else 0.0)
            return []
        burst = self.bursts.pop(0)
        for arrival in burst:
            if isinstance(arrival, Heard) and arrival.number > 0:
                self.traffic.receive(arrival.key, arrival.number)
        return burst


def stage(
    *rules: Rule, name: str = "world", bursts: Sequence[Sequence[Arrival]]
) -> tuple[FaultyTransport, list[FaultInjected]]:
    noted: list[FaultInjected] = []
    conditions = Conditions(Plan(name="test", rules=rules), 1, FAST)
    return FaultyTransport(Inner(*bursts), conditions, KEYS, name, noted.append), noted


async def all_arrivals(transport: FaultyTransport) -> list[Arrival]:
    """All arrivals until possible delays are over.

    On a busy machine 0.05 s may pass while a burst is removed: then more may come behind none.
    """
    network, arrived = transport._inner, list[Arrival]()
    assert isinstance(network, Inner)
    async with asyncio.timeout(DEADLINE_S):
        while (burst := await transport.arrivals(0.05)) or network.bursts or transport._due:
            arrived += burst
    return arrived


def drives(*numbers: int) -> list[Heard]:
    return [Heard(DRIVE, number, drive(number)) for number in numbers]


async def test_without_rules_all_messages_arrive_unchanged() -> None:
    transport, noted = stage(bursts=[drives(1, 2), [Appeared(KEYS.alive("r1", "a"))], [Refused("k", "why")]])
    arrived = await all_arrivals(transport)
    assert arrived == [*drives(1, 2), Appeared(KEYS.alive("r1", "a")), Refused("k", "why")]
    assert noted == []


async def test_a_dropped_message_is_recorded_with_key_and_number_and_counted_as_removed() -> None:
    transport, noted = stage(Drop(), bursts=[drives(1, 2)])
    assert await all_arrivals(transport) == []
    said = [(each.fault, each.rule, each.key, each.number) for each in noted]
    assert said == [("drop", "drop-1", "body/r1/drive", 1), ("drop", "drop-1", "body/r1/drive", 2)]
    traffic = transport.traffic
    assert (traffic.received[DRIVE], traffic.newest[DRIVE]) == (0, 2)
    assert traffic.injected_by_fault() == {"drop": {DRIVE: 2}}


async def test_a_damaged_message_is_refused_and_counts_neither_as_received_nor_as_foreign() -> None:
    transport, _ = stage(Corrupt(bits=3), bursts=[drives(1)])
    (refused,) = await all_arrivals(transport)
    assert isinstance(refused, Refused)
    assert refused.key == DRIVE
    assert transport.traffic.injected_by_fault() == {"corrupt": {DRIVE: 1}}
    assert transport.traffic.refused.total() == 0


async def test_a_delayed_message_arrives_later_and_counts_as_received() -> None:
    rule = Delay(delay_s_min=5.0, delay_s_max=5.0, kinds=("drive",))
    tell = [Heard(KEYS.log("r1"), 1, odometry(0.0))]
    transport, _ = stage(rule, bursts=[[*drives(1), *tell]])
    arrived = await all_arrivals(transport)
    assert arrived == [*tell, *drives(1)]
    assert transport.traffic.received[DRIVE] == 1


async def test_a_duplicated_message_counts_once_and_a_duplicated_query_arrives_once() -> None:
    asked = Asked(KEYS.mission(), Ask(), lambda _: None)
    transport, noted = stage(Duplicate(copies=2), bursts=[[*drives(1), asked]])
    arrived = await all_arrivals(transport)
    assert [type(each) for each in arrived].count(Heard) == 3
    assert arrived.count(asked) == 1
    assert transport.traffic.received[DRIVE] == 1
    assert {each.fault for each in noted} == {"duplicate"}


async def test_a_process_that_is_cut_off_shows_no_token_until_the_cut_ends() -> None:
    one, two = KEYS.alive("r1", "a"), KEYS.alive("r2", "b")
    cut = Partition(group=("r1",), others=("router",), from_s=1.0, until_s=2.0)
    transport, _ = stage(cut, bursts=[[Appeared(one), Appeared(two)]])
    assert await all_arrivals(transport) == [Appeared(one), Appeared(two)]
    transport.tell_time(1.5)
    assert await all_arrivals(transport) == [Vanished(one)]
    transport.tell_time(2.0)
    assert await all_arrivals(transport) == [Appeared(one)]


async def test_a_process_that_is_cut_off_sees_no_token_and_reads_the_time_of_removed_odometry() -> None:
    one = KEYS.alive("world", "a")
    cut = Partition(group=("r1",), others=("router",), from_s=1.0, until_s=2.0)
    told = [Heard(KEYS.odometry("r1"), number, odometry(number - 1.0)) for number in (1, 2, 3)]
    transport, _ = stage(cut, name="r1", bursts=[[Appeared(one)], told[:1], told[1:2], told[2:]])
    arrived = await all_arrivals(transport)
    assert arrived == [Appeared(one), told[0], Vanished(one), told[2], Appeared(one)]
    assert transport.now_s == 2.0


async def test_an_injection_is_recorded_at_a_time_when_its_rule_is_active() -> None:
    told = [Heard(KEYS.odometry("r1"), number, odometry(number - 1.0)) for number in (1, 2, 3)]
    rules = (Drop(sender=("world",), from_s=1.0), Drop(sender=("r2",), from_s=2.0))
    transport, noted = stage(
        *rules, name="r1", bursts=[[*told, Heard(KEYS.view("r2", "r1"), 1, odometry(0.0))]]
    )
    assert await all_arrivals(transport) == told[:1]
    assert ([each.rule for each in noted], transport.now_s) == (["drop-1", "drop-1", "drop-2"], 2.0)


async def test_a_token_that_vanishes_while_it_is_invisible_is_not_reported() -> None:
    one = KEYS.alive("r1", "a")
    transport, _ = stage(
        Partition(group=("r1",), others=("router",)), bursts=[[Appeared(one)], [Vanished(one)]]
    )
    assert await all_arrivals(transport) == []


async def test_rules_sent_by_the_world_are_active_from_then_on_and_affect_no_fault_messages() -> None:
    def told(number: int, *rules: Rule) -> Heard:
        faults = Faults(number=number, step=0, struck=(), rules=rules, slow_s=0.0)
        return Heard(KEYS.fault("r1"), number, faults)

    reports = [Heard(KEYS.view("r2", "r1"), number, odometry(0.0)) for number in (1, 2, 3)]
    said = [told(2, Drop(name="given-1")), reports[0], told(1), reports[1], told(3), reports[2]]
    transport, noted = stage(name="r1", bursts=[[each] for each in said])
    assert await all_arrivals(transport) == [reports[2]]
    assert [(each.rule, each.number) for each in noted] == [("given-1", 1), ("given-1", 2)]


async def test_what_becomes_of_queries_does_not_depend_on_a_rule_for_others_that_comes_meanwhile() -> None:
    async def answered(*meanwhile: Rule) -> list[bool]:
        asked = Asked(KEYS.scan("r1"), Ask(), lambda _: None)
        half = Drop(name="half", kinds=("ask",), probability=0.5)
        transport, _ = stage(half, bursts=[[asked] for _ in range(20)])
        transport.have(Faults(number=1, step=0, struck=(), rules=(), slow_s=0.0))
        first = [await transport.arrivals(0.0) == [asked] for _ in range(10)]
        transport.have(Faults(number=2, step=0, struck=(), rules=meanwhile, slow_s=0.0))
        return first + [await transport.arrivals(0.0) == [asked] for _ in range(10)]

    assert await answered(Drop(name="given-1", kinds=("plea",))) == await answered()


async def test_tokens_that_are_no_longer_watched_are_forgotten() -> None:
    token, other = KEYS.alive("r2", "a"), KEYS.alive("r3", "a")
    transport, _ = stage(name="r1", bursts=[[Appeared(token), Appeared(other)]])
    assert await all_arrivals(transport) == [Appeared(token), Appeared(other)]
    transport.watch([KEYS.tokens_of("r2")])
    assert await all_arrivals(transport) == [Listed()]
    cut_off = Partition(name="p", group=("r1",), others=("router",))
    transport.have(Faults(number=1, step=0, struck=(), rules=(cut_off,), slow_s=0.0))
    assert await all_arrivals(transport) == [Vanished(token)]


async def test_that_tokens_are_listed_comes_behind_the_tokens() -> None:
    token = KEYS.alive("r2", "a")
    transport, _ = stage(name="r1", bursts=[[Listed(), Appeared(token)]])
    assert await all_arrivals(transport) == [Appeared(token), Listed()]
