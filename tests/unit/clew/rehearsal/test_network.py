"""The network of a rehearsal: messages in the order in which they are due."""

from hypothesis import given
from hypothesis import strategies as st

from clew.rehearsal.network import Network


def arrived(network: Network[int], now_s: float) -> list[int]:
    messages: list[int] = []
    while (message := network.next_due(now_s)) is not None:
        messages.append(message)
    return messages


def sent(due_s: list[float]) -> Network[int]:
    network: Network[int] = Network()
    for message, each_s in enumerate(due_s):
        network.send(message, each_s)
    return network


def test_messages_due_together_arrive_in_the_order_of_sending() -> None:
    assert arrived(sent([1.0] * 500), 1.0) == list(range(500))


@given(st.lists(st.sampled_from([0.0, 0.1, 0.2, 0.3, 0.4]), max_size=50), st.sampled_from([0.0, 0.2, 0.4]))
def test_each_message_arrives_when_it_is_due_and_not_before(due_s: list[float], now_s: float) -> None:
    network = sent(due_s)
    early = arrived(network, now_s)
    assert early == sorted(
        (message for message, each_s in enumerate(due_s) if each_s <= now_s),
        key=lambda message: (due_s[message], message),
    )
    assert sorted(early + arrived(network, 1.0)) == list(range(len(due_s)))
