from protocol.network.traffic import OTHERS, REFUSED_KEYS_MAX, Traffic


def test_what_was_taken_away_has_come_and_was_not_received() -> None:
    traffic = Traffic()
    traffic.receive("a", 1)
    traffic.take_away("a", 3, "drop")
    traffic.take_away("b", 1, "drop")
    traffic.take_away("a", 2, "corrupt")
    assert (traffic.received, traffic.newest) == ({"a": 1}, {"a": 3, "b": 1})
    assert traffic.injected_by_fault() == {"corrupt": {"a": 1}, "drop": {"a": 1, "b": 1}}


def test_however_many_keys_are_made_up_the_count_of_the_refused_stays_small() -> None:
    traffic = Traffic()
    for number in range(3 * REFUSED_KEYS_MAX):
        traffic.refuse(f"forged/{number}")
    traffic.refuse("forged/0")
    assert len(traffic.refused) == REFUSED_KEYS_MAX + 1
    assert (traffic.refused["forged/0"], traffic.refused[OTHERS]) == (2, 2 * REFUSED_KEYS_MAX)
