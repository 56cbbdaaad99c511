from agents.process.asking import mission_times_s
from protocol.mission import start_wall_s


def test_a_robot_of_few_asks_often() -> None:
    assert mission_times_s(5) == (0.3, 60.0)


def test_all_robots_of_a_run_ask_no_more_often_than_a_world_can_answer_and_none_gives_up_before_it() -> None:
    for robots in (100, 200, 1000):
        period_s, patience_s = mission_times_s(robots)
        assert robots / period_s <= 250.0001  # 4 ms for each
        assert patience_s >= start_wall_s(robots)
