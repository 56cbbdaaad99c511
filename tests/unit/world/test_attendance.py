from world.attendance import GONE_S, SILENCE_S, Attendance, Coming


def both_there() -> Attendance:
    attendance = Attendance(frozenset({1, 2}))
    attendance.appear(1, "a", wall_s=0.0)
    attendance.appear(2, "b", wall_s=0.0)
    return attendance


def test_robots_that_never_came_are_named() -> None:
    attendance = Attendance(frozenset({1, 2, 3}))
    assert attendance.appear(2, "a", wall_s=0.0) is Coming.NEW
    assert attendance.missing == [1, 3]


def test_a_robot_has_died_when_its_token_is_gone_and_it_was_silent_for_a_second() -> None:
    attendance = both_there()
    attendance.hear(1, wall_s=5.0)
    attendance.vanish(1, "a", wall_s=0.0)
    assert attendance.find_deaths(wall_s=5.0 + SILENCE_S - 0.01) == []
    assert attendance.find_deaths(wall_s=5.0 + SILENCE_S) == [1]
    assert attendance.find_deaths(wall_s=9.0) == []
    assert (attendance.dead, attendance.living) == ({1}, {2})


def test_a_silent_robot_that_shows_its_token_is_alive() -> None:
    assert both_there().find_deaths(wall_s=1000.0) == []


def test_a_robot_that_is_heard_without_its_token_is_alive() -> None:
    attendance = both_there()
    attendance.vanish(1, "a", wall_s=0.0)
    attendance.hear(1, wall_s=8.0)
    assert attendance.find_deaths(wall_s=8.5) == []


def test_a_token_that_returns_in_time_is_no_death() -> None:
    attendance = both_there()
    attendance.vanish(1, "a", wall_s=0.0)
    assert attendance.appear(1, "a", wall_s=0.5) is Coming.KNOWN
    assert attendance.find_deaths(wall_s=9.0) == []


def test_a_dead_robot_whose_token_returns_was_frozen_and_is_alive() -> None:
    attendance = both_there()
    attendance.vanish(1, "a", wall_s=0.0)
    assert attendance.find_deaths(wall_s=2.0) == [1]
    assert attendance.appear(1, "a", wall_s=3.0) is Coming.RETURNED
    assert attendance.living == {1, 2}
    assert attendance.find_deaths(wall_s=9.0) == []


def test_a_robot_with_another_incarnation_was_restarted_with_or_without_a_detected_death() -> None:
    attendance = both_there()
    attendance.vanish(1, "a", wall_s=0.0)
    assert attendance.appear(1, "b", wall_s=0.1) is Coming.RESTARTED
    attendance.vanish(1, "b", wall_s=0.0)
    assert attendance.find_deaths(wall_s=2.0) == [1]
    assert attendance.appear(1, "c", wall_s=3.0) is Coming.RESTARTED
    assert attendance.living == {1, 2}


def test_a_late_loss_of_an_earlier_incarnations_token_is_no_death() -> None:
    attendance = both_there()
    attendance.appear(1, "c", wall_s=0.1)
    attendance.vanish(1, "a", wall_s=0.0)
    assert attendance.find_deaths(wall_s=9.0) == []


def test_silence_without_a_router_is_no_death() -> None:
    attendance = both_there()
    attendance.vanish(1, "a", wall_s=0.0)
    attendance.restart_silence(wall_s=5.0)
    assert attendance.find_deaths(wall_s=5.0 + SILENCE_S - 0.01) == []


def test_a_process_is_known_once_it_has_shown_its_token_even_if_that_is_gone() -> None:
    attendance = both_there()
    attendance.appear(1, "b", wall_s=1.0)
    attendance.vanish(1, "b", wall_s=0.0)
    assert [attendance.has_shown(1, incarnation) for incarnation in ("a", "b", "c")] == [True, True, False]
    attendance.forget_tokens(wall_s=2.0)
    assert attendance.has_shown(1, "b")
    again = Attendance(frozenset({1}))
    again.recall({1}, set(), set(), {1: "a"}, wall_s=3.0)
    assert again.has_shown(1, "a"), "the timeline of a resumed world shows it"


def test_nobody_has_died_when_tokens_vanish_one_by_one_with_a_link_of_ours() -> None:
    attendance = both_there()
    attendance.vanish(1, "a", wall_s=SILENCE_S)  # all were silent for as long as the router was frozen
    assert attendance.find_deaths(wall_s=SILENCE_S + GONE_S - 0.01) == []
    attendance.vanish(2, "b", wall_s=SILENCE_S + 0.01)
    attendance.forget_tokens(wall_s=SILENCE_S + 0.02)  # there is no router: that shows now
    assert attendance.find_deaths(wall_s=2.0 * SILENCE_S) == []


def test_a_robot_that_was_silent_before_its_token_vanished_has_died_a_moment_after_that() -> None:
    attendance = both_there()
    attendance.vanish(1, "a", wall_s=SILENCE_S)
    assert attendance.find_deaths(wall_s=SILENCE_S + GONE_S + 0.01) == [1]
