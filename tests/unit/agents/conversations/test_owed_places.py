"""A robot that falls silent when its turn is over, and shows its token, does not keep the others for long."""

from clew.explore.setting import SCATTERED
from protocol.fence import May
from protocol.timeline import RobotPlaced
from protocol.wire.view import Report
from tests.support.stages.view_stage import ViewStage, in_turn, of

SOON_S = 4.0


def go_on_without(stage: ViewStage, silent: int) -> None:
    epoch = stage.fence.epoch
    stage.lose(lambda post: post.sender == silent)
    stage.run(lambda: stage.fence.may is May.ALL, s_max=SOON_S)
    assert stage.formed is not None
    assert (stage.fence.epoch, set(stage.formed.order)) == (epoch, set(stage.robots) - {silent})


def test_a_robot_that_falls_silent_at_its_place_is_left_out_of_the_strand_that_forms() -> None:
    stage = in_turn(2, 3, SCATTERED)
    stage.run(lambda: bool(stage.records_of(RobotPlaced, 3)))
    stage.run(lambda: stage.fence.may is May.NOBODY)
    go_on_without(stage, 3)


def test_a_robot_that_falls_silent_at_its_place_is_left_out_of_the_draft_that_begins_again() -> None:
    stage = ViewStage.begun(SCATTERED)
    stage.raised_by(2)
    stage.lose(lambda post: post.sender == 1)
    stage.run(lambda: 3 in stage.moving())
    stage.heal()
    stage.run(lambda: bool(stage.sent(of(Report, sender=1))))
    stage.run(lambda: stage.fence.may is May.NOBODY)
    go_on_without(stage, 3)
