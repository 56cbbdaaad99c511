"""The coordinator's own turn."""

import math

from protocol.fence import May
from protocol.wire.messages import Scan
from protocol.wire.view import Answer
from tests.support.stages.view_stage import in_turn, of

PLACES = ((2.4, 1.5, 0.0), (1.2, 2.1, 0.0), (0.8, 1.0, 0.0))


def test_after_a_coordinators_own_turn_in_vain_the_next_robot_is_told_where_the_coordinator_stands() -> None:
    stage = in_turn(2, 2, PLACES)
    stage.pass_s(0.4)
    stage.lose(of(Scan, receiver=2))
    stage.run(lambda: stage.fence.may is May.ONE and stage.fence.robot == 3, s_max=40.0)
    stage.run(lambda: 3 in stage.moving(), s_max=5.0)
    joins = [post.thing.join for post in stage.sent(of(Answer, sender=2, receiver=3)) if post.thing.join]
    (waits_at,) = joins[-1].waiting
    assert math.dist(stage.place(2), PLACES[1][:2]) > 0.1
    assert math.dist(stage.place(2), (waits_at.x_m, waits_at.y_m)) < 0.01
