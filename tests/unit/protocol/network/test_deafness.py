"""When a session that is connected and hears nobody is opened anew."""

from protocol.network.deafness import DEAF_S, DEAF_S_MAX, LOOK_S_MAX, Deafness

OWN, OTHER, THIRD = "alive/r1/a", "alive/r2/b", "alive/world/c"
LOOK_S = 0.1


def alone(own: str | None = OWN) -> Deafness:
    """A session that has seen the token of another process, and sees its own alone."""
    deafness = Deafness(own)
    for key in (OWN, OTHER):
        deafness.see(key, shown=True)
    deafness.see(OTHER, shown=False)
    return deafness


def deaf_at_s(deafness: Deafness, from_s: float, to_s: float, *, connected: bool = True) -> list[float]:
    """The times at which it is to be opened anew."""
    looks = [from_s + LOOK_S * n for n in range(round((to_s - from_s) / LOOK_S))]
    return [round(at_s, 3) for at_s in looks if deafness.look(at_s, connected=connected)]


def test_a_connected_session_that_has_lost_sight_of_all_others_is_deaf() -> None:
    assert deaf_at_s(alone(), 0.0, DEAF_S + 2.0 * LOOK_S) == [DEAF_S]


def test_its_own_token_does_not_show_that_a_session_hears() -> None:
    assert alone().is_alone
    assert not alone(own=None).is_alone, "the token is of another process"


def test_a_session_that_never_sees_another_token_is_deaf_from_its_beginning() -> None:
    deafness = Deafness(OWN)
    deafness.see(OWN, shown=True)
    assert deafness.is_alone
    assert deaf_at_s(deafness, 0.0, 25.0) == [DEAF_S_MAX, 2.0 * DEAF_S_MAX]


def test_a_session_that_sees_its_first_token_late_is_not_opened_anew() -> None:
    deafness = Deafness(OWN)
    assert deaf_at_s(deafness, 0.0, DEAF_S_MAX) == []
    deafness.see(OTHER, shown=True)
    assert deaf_at_s(deafness, DEAF_S_MAX, 30.0) == []


def test_a_session_that_is_not_connected_is_not_deaf() -> None:
    deafness = alone()
    assert deaf_at_s(deafness, 0.0, 10.0, connected=False) == []
    assert deaf_at_s(deafness, 10.0, 20.0)[0] >= 10.0 + DEAF_S - LOOK_S


def test_one_token_of_another_process_is_enough() -> None:
    deafness = alone()
    assert deaf_at_s(deafness, 0.0, DEAF_S / 2.0) == []
    deafness.see(THIRD, shown=True)
    assert not deafness.is_alone
    assert deaf_at_s(deafness, DEAF_S / 2.0, 10.0) == []


def test_a_pause_of_the_process_itself_is_not_silence_of_the_others() -> None:
    deafness = alone()
    assert [deafness.look(at_s, connected=True) for at_s in (0.0, 100.0)] == [False, False]
    assert LOOK_S_MAX < DEAF_S


def test_it_is_opened_anew_less_often_while_that_does_not_help() -> None:
    deafness = alone()
    deaf = deaf_at_s(deafness, 0.0, 100.0)
    waits = [round(later - earlier, 1) for earlier, later in zip([0.0, *deaf], deaf, strict=False)]
    assert waits[:4] == [DEAF_S, 2.0 * DEAF_S, 4.0 * DEAF_S, 8.0 * DEAF_S]
    assert set(waits[5:]) == {DEAF_S_MAX}
    deafness.see(OTHER, shown=True)
    deafness.see(OTHER, shown=False)
    assert deaf_at_s(deafness, 100.0, 101.0) == [100.0 + DEAF_S]


def test_a_new_session_has_seen_no_token_yet() -> None:
    deafness = alone()
    deafness.see(THIRD, shown=True)
    assert deafness.forget() == [OWN, THIRD]
    assert deafness.forget() == []
    assert deafness.is_alone, "the new one is deaf, too, if it sees nobody"


def test_tokens_that_are_no_longer_watched_do_not_count() -> None:
    deafness = Deafness("alive/r1/a")
    for key in ("alive/r2/a", "alive/r3/a"):
        deafness.see(key, shown=True)
    deafness.forget_others(["alive/r3/*"])
    assert not deafness.is_alone
    deafness.see("alive/r3/a", shown=False)
    assert deafness.is_alone
