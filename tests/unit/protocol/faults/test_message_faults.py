"""Effects on messages depend only on seed, rule and message: not on order or other messages."""

import itertools
import math
from collections import Counter
from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocol.errors import MessageRefusedError
from protocol.faults.chance import Chance, Draws
from protocol.faults.damage import Damage
from protocol.faults.message_faults import NO_EFFECT, Copy, Effect, Injection, MessageFaults, sender_of
from protocol.faults.plan import NO_FAULTS, Plan, uniform
from protocol.faults.rules import Burst, Corrupt, Delay, Drop, Duplicate, Partition, Reorder, Rule
from protocol.fence import Turn
from protocol.wire.codec import decode, encode
from protocol.wire.messages import AheadState, Drive, Message, Odometry, Scan
from protocol.wire.view import Answer, Report
from tests.support.strategies.examples import examples
from tests.support.strategies.message_strategies import values_of

SIGMAS = 4.5  # fair draws deviate further once in 150,000 cases
COUNT = 4000
Sent = tuple[str, str, int, str]  # key, kind, number, receiver

KINDS = [
    ("link/r1/r2", "ahead", "r2"),
    ("link/r2/r1", "behind", "r1"),
    ("body/r1/odometry", "odometry", "r1"),
    ("body/r2/drive", "drive", "world"),
    ("view/r1/r2", "report", "r2"),
    ("view/r1/r3", "plea", "r3"),
    ("body/fence/r1", "turn", "world"),
]
DAMAGED = (AheadState, Answer, Drive, Odometry, Report, Scan, Turn)
RULES: list[Rule] = [
    Drop(name="loss", probability=0.3),
    Drop(name="burst", burst=Burst(enter=0.1, leave=0.3, loss=0.8)),
    Delay(name="late", probability=0.5, delay_s_max=0.4),
    Duplicate(name="twice", probability=0.4, copies=2, delay_s_max=0.2),
    Corrupt(name="noise", probability=0.2, bits=2),
]
sent = st.lists(
    st.tuples(st.sampled_from(KINDS), st.integers(1, 60)).map(
        lambda each: (each[0][0], each[0][1], each[1], each[0][2])
    ),
    unique=True,
    max_size=40,
)


def message_faults(*rules: Rule, seed: int = 1) -> MessageFaults:
    return MessageFaults(Plan(name="test", rules=tuple(rules)), seed)


def effect(of: MessageFaults, message: Sent, now_s: float = 0.0, step: int = 0) -> Effect:
    key, kind, number, receiver = message
    return of.of(key, kind, number, receiver, now_s=now_s, step=step)


def struck(of: MessageFaults, count: int = COUNT) -> list[bool]:
    """For each of so many messages of one key: whether it is affected."""
    return [bool(effect(of, ("link/r1/r2", "ahead", n, "r2")).injections) for n in range(1, count + 1)]


def is_fair(hits: int, count: int, probability: float) -> bool:
    return abs(hits - count * probability) <= SIGMAS * math.sqrt(count * probability * (1 - probability))


@given(sent, st.randoms(use_true_random=False), st.integers(0, 99))
def test_the_order_of_arrival_does_not_change_the_effects(
    messages: list[Sent], random: object, seed: int
) -> None:
    shuffled = list(messages)
    random.shuffle(shuffled)  # type: ignore[attr-defined]  # hypothesis has no type for its random
    one, other = message_faults(*RULES, seed=seed), message_faults(*RULES, seed=seed)
    first = {message: effect(one, message) for message in messages}
    assert {message: effect(other, message) for message in shuffled} == first


@given(sent, st.integers(0, 60), st.sampled_from(RULES))
def test_other_messages_and_other_rules_do_not_change_the_effects(
    messages: list[Sent], left_out: int, rule: Rule
) -> None:
    alone, among = message_faults(rule), message_faults(*RULES)
    fewer = [message for message in messages if message[2] != left_out]
    by_all = {message: effect(among, message) for message in messages}
    name = str(rule.name)
    for message in fewer:
        decided = Injection(name, rule.fault) in effect(alone, message).injections
        reached = Injection(name, rule.fault) in by_all[message].injections
        assert decided or not reached
        assert reached or not decided or not by_all[message].copies


@pytest.mark.parametrize("probability", [0.02, 0.3, 0.5, 0.9])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_share_of_affected_messages_matches_the_probability(seed: int, probability: float) -> None:
    hits = struck(message_faults(Drop(probability=probability), seed=seed))
    assert is_fair(sum(hits), COUNT, probability)
    pairs = sum(one and other for one, other in itertools.pairwise(hits))
    assert is_fair(pairs, COUNT - 1, probability**2), "messages next to each other have nothing in common"


@pytest.mark.parametrize("probability", [0.0, 1.0])
def test_probability_zero_never_strikes_and_one_always_strikes(probability: float) -> None:
    assert set(struck(message_faults(Drop(probability=probability)), 500)) == {probability == 1.0}


def test_rules_receivers_and_seeds_have_independent_draws() -> None:
    def drawn(of: MessageFaults, receiver: str) -> list[bool]:
        return [bool(effect(of, ("view/r1/r2", "report", n, receiver)).injections) for n in range(1, COUNT)]

    half = [
        drawn(message_faults(Drop(name="a", probability=0.5)), "r2"),
        drawn(message_faults(Drop(name="b", probability=0.5)), "r2"),
        drawn(message_faults(Drop(name="a", probability=0.5), seed=2), "r2"),
        drawn(message_faults(Drop(name="a", probability=0.5)), "r3"),
    ]
    for one, other in itertools.combinations(half, 2):
        alike = sum(a == b for a, b in zip(one, other, strict=True))
        assert is_fair(alike, COUNT, 0.5)


@pytest.mark.parametrize(("enter", "leave"), [(0.05, 0.2), (0.2, 0.5), (0.01, 0.1)])
def test_bursts_have_the_length_and_number_of_the_gilbert_elliott_model(enter: float, leave: float) -> None:
    hits = struck(message_faults(Drop(burst=Burst(enter=enter, leave=leave, loss=1.0))), 4 * COUNT)
    runs = [len(list(run)) for lost, run in itertools.groupby(hits) if lost]
    mean = sum(runs) / len(runs)
    # Lengths are geometric, with mean 1 / leave and standard deviation sqrt(1 - leave) / leave.
    assert abs(mean - 1 / leave) <= SIGMAS * math.sqrt((1 - leave) / len(runs)) / leave
    share = sum(hits) / len(hits)
    # Neighbouring draws are correlated: each counts for (2 - enter - leave) / (enter + leave) fewer.
    effective = len(hits) * (enter + leave) / (2 - enter - leave)
    expected = enter / (enter + leave)
    assert abs(share - expected) <= SIGMAS * math.sqrt(expected * (1 - expected) / effective)


def test_the_draws_of_long_bursts_are_looked_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    looked = Counter[int | str]()

    def counted(chance: Chance, number: int | str) -> Draws:
        looked[number] += 1
        return of_chance(chance, number)

    of_chance = Chance.draws
    monkeypatch.setattr(Chance, "draws", counted)
    struck(message_faults(Drop(burst=Burst(enter=0.001, leave=0.001, loss=1.0))))
    assert max(looked.values()) <= 2, "once for its burst, and once for the message itself"


def test_within_a_burst_the_loss_rate_matches_the_rule() -> None:
    burst = Burst(enter=0.1, leave=0.1, loss=0.6)
    in_burst = struck(message_faults(Drop(name="a", burst=Burst(enter=0.1, leave=0.1, loss=1.0))))
    lost = struck(message_faults(Drop(name="a", burst=burst)))
    assert not any(hit and not bad for hit, bad in zip(lost, in_burst, strict=True))
    assert is_fair(sum(lost), sum(in_burst), 0.6)


@given(st.floats(0.0, 0.5), st.floats(0.5, 2.0), st.integers(1, 1000))
def test_delays_keep_their_bounds(low_s: float, high_s: float, number: int) -> None:
    (copy,) = effect(
        message_faults(Delay(delay_s_min=low_s, delay_s_max=high_s)), ("link/r1/r2", "ahead", number, "r2")
    ).copies
    assert low_s <= copy.delay_s <= high_s


def test_faults_add_up_and_later_rules_do_not_see_a_lost_message() -> None:
    held = effect(message_faults(Reorder(hold_s=0.5), Reorder(hold_s=0.25)), ("link/r1/r2", "ahead", 1, "r2"))
    assert held.copies == (Copy(0.75),)
    twice = effect(message_faults(Duplicate(copies=2), Reorder(hold_s=0.5)), ("link/r1/r2", "ahead", 1, "r2"))
    assert twice.copies == (Copy(0.5),) * 3
    lost = effect(message_faults(Drop(), Duplicate()), ("link/r1/r2", "ahead", 1, "r2"))
    assert lost == Effect((), (Injection("drop-1", "drop"),))
    assert (lost.removed_by, twice.removed_by) == ("drop", None)


@settings(max_examples=examples(200))
@given(
    st.one_of([values_of(kind) for kind in DAMAGED]),
    st.integers(1, 8),
    st.booleans(),
    st.integers(0, 2**64 - 1),
)
def test_the_codec_refuses_every_damaged_message(message: Message, bits: int, cut: bool, seed: int) -> None:
    payload = encode(message, 7)
    damaged = Damage(bits, cut, seed).apply(payload)
    assert damaged != payload
    with pytest.raises(MessageRefusedError):
        decode(damaged)


@given(st.binary(min_size=1, max_size=50), st.integers(1, 500), st.integers(0, 99))
def test_the_number_of_flipped_bits_matches_the_rule(payload: bytes, bits: int, seed: int) -> None:
    damaged = Damage(bits, truncate=False, seed=seed).apply(payload)
    flipped = sum((a ^ b).bit_count() for a, b in zip(payload, damaged, strict=True))
    assert flipped == min(bits, 8 * len(payload))


@pytest.mark.parametrize(
    ("rule", "lost"),
    [
        (Drop(sender=("r1",)), {"link/r1/r2", "view/r1/r2", "view/r1/r3", "body/fence/r1"}),
        (Drop(receiver=("world",)), {"body/r2/drive", "body/fence/r1"}),
        (Drop(kinds=("turn", "plea")), {"view/r1/r3", "body/fence/r1"}),
        (Drop(kinds=("odometry", "behind")), {"body/r1/odometry", "link/r2/r1"}),
        (Partition(group=("r1",)), {key for key, _, _ in KINDS} - {"body/r2/drive"}),
        (Partition(group=("r1",), others=("r2",), one_way=True), {"link/r1/r2", "view/r1/r2"}),
        (Partition(group=("r2",), others=("r1",), one_way=True), {"link/r2/r1"}),
        (
            Partition(group=("world",), others=("router",)),
            {"body/r1/odometry", "body/r2/drive", "body/fence/r1"},
        ),
        (Partition(group=("router",)), {key for key, _, _ in KINDS}),
    ],
)
def test_a_rule_affects_only_the_messages_that_it_names(rule: Rule, lost: set[str]) -> None:
    of = message_faults(rule)
    gone = {key for key, kind, receiver in KINDS if not effect(of, (key, kind, 1, receiver)).copies}
    assert gone == lost


@pytest.mark.parametrize(
    ("now_s", "step", "holds"),
    [(1.9, 5, False), (2.0, 5, True), (3.9, 5, True), (4.0, 5, False), (2.0, 2, False), (2.0, 6, False)],
)
def test_a_rule_is_active_only_in_its_window_of_time_and_steps(now_s: float, step: int, holds: bool) -> None:
    of = message_faults(Drop(from_s=2.0, until_s=4.0, from_step=3, until_step=6))
    assert bool(effect(of, ("link/r1/r2", "ahead", 1, "r2"), now_s, step).injections) == holds


def test_a_periodic_partition_starts_its_period_at_its_own_start() -> None:
    of = message_faults(Partition(group=("r1",), from_s=1.0, period_s=2.0, cut_s=0.5))
    times_s = [0.9, 1.0, 1.4, 1.5, 2.9, 3.0, 3.4, 3.6]
    cut = [not effect(of, ("link/r1/r2", "ahead", 1, "r2"), now_s).copies for now_s in times_s]
    assert cut == [False, True, True, False, False, True, True, False]


def test_the_plan_knows_which_processes_are_cut_off_from_the_router() -> None:
    of = message_faults(Partition(group=("r1", "r2"), others=("router",), from_s=1.0))
    assert of.may_cut
    assert [of.is_cut(name, now_s=1.0, step=0) for name in ("r1", "r2", "r3", "world")] == [True] * 2 + [
        False
    ] * 2
    assert not of.is_cut("r1", now_s=0.9, step=0)
    leaky = message_faults(Partition(group=("r1",), others=("router",), probability=0.9))
    assert not leaky.may_cut, "what gets through keeps the connection"


@pytest.mark.parametrize(
    ("key", "kind", "receiver"), [("log/r1", "log", "world"), ("logged/r1", "logged", "r1")]
)
def test_the_recorders_messages_are_affected_only_if_a_rule_names_them(
    key: str, kind: str, receiver: str
) -> None:
    assert effect(message_faults(Drop(), Partition(group=("r1",))), (key, kind, 1, receiver)) == NO_EFFECT
    assert not effect(message_faults(Drop(kinds=("log", "logged"))), (key, kind, 1, receiver)).copies


def test_queries_and_replies_are_counted_at_the_receiver() -> None:
    of, scan = message_faults(Drop(probability=0.5)), ("body/r1/scan", "scan", 0, "r1")
    answers = [bool(effect(of, scan).injections) for _ in range(COUNT)]
    questions = [
        bool(effect(of, ("body/r1/scan", "scan_query", 0, "world")).injections) for _ in range(COUNT)
    ]
    assert is_fair(sum(answers), COUNT, 0.5)
    assert is_fair(sum(a == b for a, b in zip(answers, questions, strict=True)), COUNT, 0.5)


@pytest.mark.parametrize(
    ("key", "receiver", "sender"),
    [
        ("link/r1/r2", "r2", "r1"),
        ("body/r3/drive", "world", "r3"),
        ("body/r3/odometry", "r3", "world"),
        ("body/r3/scan", "r3", "world"),
        ("body/r3/scan", "world", "r3"),
        ("view/r4/r2", "r2", "r4"),
        ("body/fence/r4", "world", "r4"),
        ("mission", "r2", "world"),
        ("mission", "world", ""),
        ("log/r2", "world", "r2"),
        ("logged/r2", "r2", "world"),
    ],
)
def test_the_sender_follows_from_key_and_receiver(key: str, receiver: str, sender: str) -> None:
    assert sender_of(key, receiver) == sender


def test_a_plan_without_rules_has_no_effect() -> None:
    assert effect(MessageFaults(NO_FAULTS, 1), ("link/r1/r2", "ahead", 1, "r2")) is NO_EFFECT
    everything: Sequence[Rule] = uniform(loss=0.1, delay_s_max=0.2, repeat=0.1).rules
    assert [rule.fault for rule in everything] == ["drop", "duplicate", "delay"]


@pytest.mark.parametrize(
    ("rule", "held_up"),
    [
        (Drop(name="a", probability=0.1), {"r1", "r2"}),
        (Delay(name="a", delay_s_max=1.0, kinds=("odometry",), receiver=("r2",)), {"r2"}),
        (Delay(name="a", delay_s_max=1.0, kinds=("drive",), sender=("r1",)), {"r1"}),
        (Partition(name="a", group=("r1",), others=("world",)), {"r1"}),
        (Drop(name="a", kinds=("ahead",)), set()),
        (Drop(name="a", until_s=5.0), set()),
        (Drop(name="a", from_s=5.1), set()),
    ],
)
def test_a_robot_is_held_up_while_a_rule_may_strike_its_odometry_or_its_orders(
    rule: Rule, held_up: set[str]
) -> None:
    faults = message_faults(rule)
    assert {robot for robot in ("r1", "r2") if faults.hold_up(robot, now_s=5.0, step=0)} == held_up
