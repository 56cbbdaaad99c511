"""A process that was stopped before it gave an order, and goes on when another one has driven the body."""

from agents.events import OdometryHeard
from agents.robot import Robot
from clew.explore.moments import WORLD
from clew.explore.setting import Setting
from protocol.fence import May
from protocol.process.tokens import TokenCame
from protocol.wire.messages import AheadState, Odometry
from tests.support.stages.view_stage import Post, Process, ViewStage, of

QUEUE = tuple((0.4 + 0.5 * place, 1.0, 0.0) for place in (3, 2, 1, 0))
LANE = Setting(
    name="lane", about="a way without a corner", places=QUEUE, goal_m=(11.0, 1.0), size_m=(12.0, 3.0)
)
LIFE = 77
DRIVEN_S = 0.4
ORDERS = 2  # of the other process by then; the stopped one has given none


def test_a_process_takes_no_order_of_another_one_for_its_own() -> None:
    """F4: it grants no ground that its body stands on; the judge of the exploration asks in every step."""
    stage = ViewStage.begun(QUEUE, LANE.scenario())
    stopped = Robot(2, stage.scenario.mission(), life=LIFE)
    stage.run(lambda: bool(stage.sent(of(Odometry, receiver=2))))
    first = stage.sent(of(Odometry, receiver=2))[0].thing
    stopped.handle(OdometryHeard(first), first.t_s)

    body = stage.world.bodies[1]
    stage.run(lambda: stage.fence.may is May.ALL)
    stage.pass_s(DRIVEN_S)
    stage.kill(2)
    epoch = stage.fence.epoch
    stage.processes[2], stage.lives[2] = Process(stopped, LIFE, first.t_s, first), LIFE
    stage.deliver(Post(2, WORLD, 0, TokenCame(2, str(LIFE))))
    for other in (1, 3, 4):
        stage.deliver(Post(WORLD, other, 0, TokenCame(2, str(LIFE))))
        stage.deliver(Post(WORLD, 2, 0, TokenCame(other, str(stage.lives[other]))))
    stage.run(lambda: stage.fence.epoch != epoch and stage.fence.may is May.ALL)
    assert body.finished_number == ORDERS
    stage.run(lambda: stopped.order.target is not None)

    stage.lose(of(AheadState, receiver=2))
    stage.pass_s(3.0)
    stage.heal()
    stage.pass_s(5.0)

    member = stopped.member
    assert member is not None
    assert stage.apart_m(2, 3) >= stage.scenario.mission().robot_keep_m - 0.01, "they have not met"
    assert 2 in stage.moving(), "and its body obeys it"
