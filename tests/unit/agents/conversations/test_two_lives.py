"""Two processes of one robot: a second one is started while the first, a member, still lives."""

import pytest

from clew.explore.moments import WORLD
from clew.explore.setting import Setting
from protocol.fence import Bearing
from protocol.wire.messages import Drive
from tests.support.stages.view_stage import Post, ViewStage, of

QUEUE = tuple((0.4 + 0.5 * place, 1.0, 0.0) for place in (3, 2, 1, 0))
LANE = Setting(
    name="lane", about="a way without a corner", places=QUEUE, goal_m=(11.0, 1.0), size_m=(12.0, 3.0)
)
LATE = 10**6  # above the number of any letter
STEPS_S = 5.0


@pytest.mark.parametrize("driven_s", [0.3, 3.0])
def test_a_member_whose_body_a_second_process_stops_grants_no_ground_that_its_body_stands_on(
    driven_s: float,
) -> None:
    """F1, F4: the judge of the exploration asks in every step how near bodies may come to each other."""
    stage = ViewStage.driving(QUEUE, LANE.scenario())
    stage.pass_s(driven_s)
    body = stage.world.bodies[1]
    assert body.moves
    number = max(body.ordered, int(stage.now_s * 10_000)) + 1001  # as `Driver.start_again` numbers it
    stand = Drive(
        number=number,
        basis_s=stage.now_s,
        target=None,
        speed_mps=0.3,
        bearing=Bearing(),
        step=0,
        reach_m=0.0,
    )
    stage.post(Post(2, WORLD, LATE, stand))
    stage.pass_s(STEPS_S)
    assert stage.sent(of(Drive, sender=2)), "its first process goes on"
    assert body.ordered == number, "its orders are older than the stop"
    assert 3 not in stage.moving()
