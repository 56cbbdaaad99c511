from protocol.network.traffic import OTHERS, REFUSED_KEYS_MAX, Traffic


def test_a_removed_message_has_arrived_but_was_not_received() -> None:
    traffic = Traffic()
    traffic.receive("a", 1)
    traffic.count_removed("a", 3, "drop")
    traffic.count_removed("b", 1, "drop")
    traffic.count_removed("a", 2, "corrupt")
    assert (traffic.received, traffic.newest) == ({"a": 1}, {"a": 3, "b": 1})
    assert traffic.injected_by_fault() == {"corrupt": {"a": 1}, "drop": {"a": 1, "b": 1}}


def test_the_counts_of_refused_keys_stay_bounded_for_any_number_of_invented_keys() -> None:
    traffic = Traffic()
    for number in range(3 * REFUSED_KEYS_MAX):
        traffic.refuse(f"forged/{number}")
    traffic.refuse("forged/0")
    assert len(traffic.refused) == REFUSED_KEYS_MAX + 1
    assert (traffic.refused["forged/0"], traffic.refused[OTHERS]) == (2, 2 * REFUSED_KEYS_MAX)
