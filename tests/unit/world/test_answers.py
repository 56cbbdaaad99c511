"""At each odometry instant all robots have odometry, or a share of many."""

import pytest

from world.answers import PATIENCE_S, SLACK_S, Answers, due


@pytest.mark.parametrize(("robots", "every"), [(5, 1), (200, 1), (201, 2), (400, 2), (401, 3), (2000, 3)])
def test_each_robot_has_odometry_in_its_turn_and_of_many_robots_only_a_share_at_once(
    robots: int, every: int
) -> None:
    fleet = range(1, robots + 1)
    shares = [due(fleet, instant, in_all=robots) for instant in range(7, 7 + every)]
    assert sorted(robot for share in shares for robot in share) == [*fleet]
    assert max(map(len, shares)) - min(map(len, shares)) <= 1
    assert due(fleet, 7 + every, in_all=robots) == shares[0]


def test_the_robots_of_a_small_fleet_beside_large_ones_take_turns_too() -> None:
    assert due({1, 2, 3}, 0, in_all=1000) == {3}


def test_a_robot_that_owes_the_answer_to_one_turn_is_not_behind_and_to_two_it_is() -> None:
    answers = Answers()
    answers.begin([1], wall_s=0.0)
    answers.answer(1, 0.6, late_s=0.0, wall_s=0.0)
    answers.tell(1, 0.9)  # 0.9 - 0.6 is a little more than 0.3
    assert list(answers.behind(slack_s=SLACK_S)) == []
    answers.tell(1, 1.2)
    assert list(answers.behind(slack_s=SLACK_S)) == [1]


@pytest.mark.parametrize(("robots", "longest_s"), [(5, PATIENCE_S), (250, PATIENCE_S), (1000, 40.0)])
def test_the_clock_waits_longer_for_a_robot_beside_many(robots: int, longest_s: float) -> None:
    answers = Answers(robots)
    answers.begin([1], wall_s=0.0)
    answers.tell(1, 1.0)
    everyone, before_s = {1}, longest_s - 0.1
    assert list(answers.late(everyone, everyone, wall_s=before_s)) == [1]
    assert list(answers.late(everyone, everyone, wall_s=longest_s)) == []
    assert list(answers.late(everyone, set(), wall_s=before_s)) == []  # it shows no token
