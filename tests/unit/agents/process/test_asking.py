from agents.process.asking import Asking, mission_times_s
from protocol.mission import start_wall_s


def test_a_robot_of_few_asks_often() -> None:
    assert mission_times_s(5) == (0.3, 60.0)


def test_all_robots_of_a_run_ask_no_more_often_than_a_world_can_answer_and_none_gives_up_before_it() -> None:
    for robots in (100, 200, 1000):
        period_s, patience_s = mission_times_s(robots)
        assert robots / period_s <= 250.0001  # 4 ms for each
        assert patience_s >= start_wall_s(robots)


def test_a_robot_asks_when_the_world_comes_and_not_again_within_the_period() -> None:
    asking = Asking(5, 0.0)
    assert not asking.asks(0.01), "nobody is there yet"
    asking.world_came()
    assert [asking.asks(0.02), asking.asks(0.03), asking.asks(0.31), asking.asks(0.33)] == [
        True,
        False,
        False,
        True,
    ]


def test_a_robot_that_sees_no_token_asks_all_the_same_until_it_gives_up() -> None:
    asking = Asking(5, 0.0)
    assert asking.wait_s(0.1) == 0.3 - 0.1
    assert asking.asks(0.3)
    assert not asking.is_over(59.9)
    assert asking.is_over(60.0)
