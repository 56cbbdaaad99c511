"""A strand has closed up at the goal, where it drives no further: a robot in its middle is started again."""

from protocol.fence import May
from protocol.timeline import OrderAccepted, RobotArrived
from tests.support.stages.view_stage import ViewStage

PLACES = ((2.0, 1.0, 0.0), (1.4, 1.0, 0.0), (2.0, 2.2, 0.0), (1.2, 2.2, 0.0))


def test_robots_of_a_strand_that_has_closed_up_are_one_again_without_a_move() -> None:
    stage = ViewStage.driving(PLACES)
    stage.run(lambda: len({robot for robot, _, said in stage.records if isinstance(said, RobotArrived)}) == 4)
    assert stage.formed is not None
    before = stage.formed.order
    stage.kill(middle := before[2])
    stage.start(middle)
    generation = stage.fence.epoch.generation
    stage.records.clear()
    stage.run(
        lambda: (
            stage.fence.epoch.generation > generation
            and stage.fence.may is May.ALL
            and stage.fence.members == len(before)
        ),
        s_max=20.0,
    )
    assert stage.formed.order == before
    assert not [each for each in stage.records_of(OrderAccepted) if each.target is not None]
