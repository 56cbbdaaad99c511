"""The network of a rehearsal does what its faults say, and a seed decides it."""

from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lab.network import Network, NetworkFaults


def arrived(network: Network[int], now_s: float) -> list[int]:
    messages: list[int] = []
    while (message := network.next_due(now_s)) is not None:
        messages.append(message)
    return messages


def sent(faults: NetworkFaults, seed: int, count: int = 500) -> Network[int]:
    network: Network[int] = Network(faults, Random(seed))
    for message in range(count):
        network.send(message, now_s=0.0)
    return network


def test_a_perfect_network_delivers_everything_at_once_and_in_order() -> None:
    assert arrived(sent(NetworkFaults(), 1), 0.0) == list(range(500))


@given(st.integers(0, 1000))
def test_a_seed_decides_the_fate_of_every_message(seed: int) -> None:
    faults = NetworkFaults(delay_s_max=1.0, loss_probability=0.2, repeat_probability=0.2)
    assert arrived(sent(faults, seed), 1.0) == arrived(sent(faults, seed), 1.0)


def test_nothing_arrives_before_it_is_due_and_everything_by_the_longest_delay() -> None:
    network = sent(NetworkFaults(delay_s_max=1.0), 1)
    early = arrived(network, 0.5)
    late = arrived(network, 1.0)
    assert 150 < len(early) < 350
    assert sorted(early + late) == list(range(500))
    assert early != sorted(early), "delays differ, so messages overtake each other"


def test_what_is_lost_and_repeated_is_counted() -> None:
    network = sent(NetworkFaults(loss_probability=0.3, repeat_probability=0.1), 1)
    messages = arrived(network, 0.0)
    assert network.fates["sent"] == 500
    assert len(messages) == 500 - network.fates["lost"] + network.fates["repeated"]
    assert 100 < network.fates["lost"] < 200
    assert 10 < network.fates["repeated"] < 70


@pytest.mark.parametrize(
    ("name", "value"), [("loss_probability", 1.5), ("repeat_probability", -0.1), ("delay_s_max", -1.0)]
)
def test_faults_that_cannot_be_are_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=name):
        NetworkFaults(**{name: value})
