from world.attendance import SILENCE_S, Attendance


def both_there() -> Attendance:
    attendance = Attendance(frozenset({1, 2}))
    attendance.appear(1, "a", wall_s=0.0)
    attendance.appear(2, "b", wall_s=0.0)
    return attendance


def test_those_who_never_came_are_named() -> None:
    attendance = Attendance(frozenset({1, 2, 3}))
    assert attendance.appear(2, "a", wall_s=0.0)
    assert attendance.missing == [1, 3]


def test_a_robot_has_died_when_its_token_is_gone_and_it_was_silent_for_a_second() -> None:
    attendance = both_there()
    attendance.hear(1, wall_s=5.0)
    attendance.vanish(1, "a")
    assert attendance.bury(wall_s=5.0 + SILENCE_S - 0.01) == []
    assert attendance.bury(wall_s=5.0 + SILENCE_S) == [1]
    assert attendance.bury(wall_s=9.0) == []
    assert (attendance.dead, attendance.living) == ({1}, {2})


def test_a_silent_robot_that_shows_its_token_lives() -> None:
    assert both_there().bury(wall_s=1000.0) == []


def test_a_robot_that_is_heard_without_its_token_lives() -> None:
    attendance = both_there()
    attendance.vanish(1, "a")
    attendance.hear(1, wall_s=8.0)
    assert attendance.bury(wall_s=8.5) == []


def test_a_token_that_comes_back_in_time_killed_nobody() -> None:
    attendance = both_there()
    attendance.vanish(1, "a")
    assert not attendance.appear(1, "c", wall_s=0.5)
    assert attendance.bury(wall_s=9.0) == []
