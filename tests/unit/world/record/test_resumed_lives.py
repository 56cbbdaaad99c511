"""A resumed world knows which processes it has seen: no life is recorded twice, and none is missed.

A process can be seen long before anything that it says is recorded, as when a large fleet starts.
"""

from protocol.process.tokens import TokenCame
from protocol.timeline import RobotDied, RobotRestarted
from tests.support.scenes.world_scenarios import scenario
from tests.support.stages.world_stage import Stage


def begun() -> Stage:
    """A run whose robots have come, and have recorded nothing."""
    stage = Stage(scenario())
    stage.begin()
    return stage


def test_a_robot_that_has_come_does_not_come_again() -> None:
    after = begun().resumed()
    assert [after.handle(TokenCame(robot, "a")) for robot in (1, 2)] == [[], []]


def test_a_robot_that_is_started_again_while_the_world_is_away_has_died() -> None:
    after = begun().resumed()
    died, restarted, *_ = after.handle(TokenCame(2, "b"))
    assert isinstance(died, RobotDied)
    assert restarted == RobotRestarted(robot=2, incarnation="b")


def test_a_restart_that_is_recorded_is_not_recorded_again() -> None:
    before = begun()
    before.handle(TokenCame(2, "b"))
    after = before.resumed()
    assert [after.handle(TokenCame(*token)) for token in ((1, "a"), (2, "b"))] == [[], []]
