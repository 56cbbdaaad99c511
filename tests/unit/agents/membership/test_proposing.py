"""When a bound robot gives its coordinator up, and one that is left out its leader."""

import pytest

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Put
from agents.liveness.suspicion import Suspicion
from agents.liveness.timing import Timing
from agents.membership.places import Past
from agents.membership.pleas import Pleas
from agents.membership.proposing import Proposing
from agents.membership.reporting import Reporter
from agents.strand.memory import Memory
from protocol.fence import Cause, Epoch, Fence, May, Raise
from protocol.frames import Point, Pose
from protocol.keys import WORLD_NUMBER
from protocol.wire.messages import Odometry, Phase
from tests.support.stages.one_step import under

MISSION = under("certified", robots=3, robot_radius_m=0.1, goal=Point(x_m=5.0, y_m=0.0))
TIMING = Timing()
EPOCH = Epoch(generation=2, robot=1, life=5)
TURN = Fence(epoch=EPOCH, turn=1, may=May.ONE, robot=3, life=9)
LIFE = 77


def odometry(tenth: int, fence: Fence, *, stood_s: float) -> Odometry:
    """What a body that stands tells after so many tenths of a second."""
    return Odometry(
        n=tenth + 1,
        t_s=tenth / 10.0,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        moving=False,
        finished=0,
        fence=fence,
        stood_s=stood_s,
        phase=Phase.RUNNING,
    )


def raised_at_s(*, last_moved_s: float) -> float | None:
    """When a robot whose reports are not answered puts a raise, in the turn of another."""
    suspicion = Suspicion(TIMING)
    suspicion.presence.come(WORLD_NUMBER, "world", 0.0)
    driver = Driver(speed_mps=0.3)
    senses, memory = Senses(MISSION, driver), Memory(MISSION)
    reporter = Reporter(EPOCH, LIFE, MISSION, TIMING, memory, Past(), heard_at_s=0.0)
    proposing = Proposing(2, LIFE, TIMING, suspicion, Pleas(TIMING))
    proposing.enter(TURN, 0.0)
    for tenth in range(80):
        now_s = tenth / 10.0
        suspicion.live(now_s)
        told = odometry(tenth, TURN, stood_s=max(0.0, now_s - last_moved_s))
        driver.hear(told)
        reporter.act(driver, senses, now_s)
        commands = proposing.act(told, reporter, None, now_s)
        if any(isinstance(command, Put) for command in commands):
            return now_s
    return None


def test_a_coordinator_that_does_not_answer_is_given_up_when_nobody_moves() -> None:
    raised_s = raised_at_s(last_moved_s=0.0)
    assert raised_s is not None
    assert TIMING.coordinator_s < raised_s < TIMING.coordinator_s + 2.0


def test_it_is_not_given_up_while_a_robot_moves_in_its_turn() -> None:
    assert raised_at_s(last_moved_s=7.0) is None


@pytest.mark.parametrize("leader_lives", [True, False])
def test_where_no_body_moves_one_that_is_left_out_raises_as_any_robot_only_if_the_leader_has_gone(
    leader_lives: bool,
) -> None:
    """A strand that has arrived stands, too: one robot that is cut off from it must not end that."""
    suspicion = Suspicion(TIMING)
    suspicion.presence.come(WORLD_NUMBER, "world", 0.0)
    suspicion.presence.come(1, "leader", 0.0)
    proposing = Proposing(3, LIFE, TIMING, suspicion, Pleas(TIMING))
    reporter = Reporter(EPOCH, LIFE, MISSION, TIMING, Memory(MISSION), Past(), heard_at_s=0.0)
    fence = Fence(epoch=EPOCH, turn=2, may=May.ALL, robot=1, members=2)
    proposing.enter(fence, 0.0)
    if not leader_lives:
        suspicion.presence.go(1, "leader", 1.0)
    raises = []
    for tenth in range(10 * round(TIMING.stood_s) + 20):
        now_s = tenth / 10.0
        suspicion.live(now_s)
        told = odometry(tenth, fence, stood_s=now_s)
        commands = proposing.act(told, reporter, None, now_s)
        puts = [each.change for each in commands if isinstance(each, Put)]
        raises += [each.cause is Cause.OUTSIDERS for each in puts if isinstance(each, Raise)]
    assert raises[0]
    assert raises[-1] is leader_lives
