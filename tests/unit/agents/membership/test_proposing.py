"""When a bound robot gives its coordinator up."""

from agents.commands import Put
from agents.liveness.suspicion import Suspicion
from agents.membership.pleas import Pleas
from agents.membership.proposing import Proposing
from protocol.fence import Fence, May
from protocol.keys import WORLD_NUMBER
from protocol.wire.messages import Odometry, Phase
from tests.unit.agents.membership.test_reporting import EPOCH, HERE, LIFE, TIMING, Bound

TURN = Fence(epoch=EPOCH, turn=1, may=May.ONE, robot=3, life=9)


def raised_at_s(*, last_moved_s: float, until_s: float = 8.0) -> float | None:
    """When a robot whose reports are not answered puts a raise, in the turn of another."""
    suspicion = Suspicion(TIMING, silent_s_max=2.0)
    suspicion.presence.come(WORLD_NUMBER, "world", 0.0)
    bound, proposing = Bound(), Proposing(2, LIFE, TIMING, suspicion, Pleas(TIMING))
    proposing.enter(TURN, 0.0)
    for tenth in range(int(10 * until_s)):
        now_s = tenth / 10.0
        suspicion.live(now_s)
        bound.at(now_s)
        told = Odometry(
            n=tenth + 1, t_s=now_s, pose=HERE, moving=False, finished=0, fence=TURN, phase=Phase.RUNNING,
            stood_s=max(0.0, now_s - last_moved_s),
        )  # fmt: skip
        if any(isinstance(each, Put) for each in proposing.act(
            TURN, told, bound.reporter, None, now_s, coordinates=False
        )):  # fmt: skip
            return now_s
    return None


def test_a_coordinator_that_does_not_answer_is_given_up_when_nobody_moves() -> None:
    raised_s = raised_at_s(last_moved_s=0.0)
    assert raised_s is not None
    assert TIMING.coordinator_s < raised_s < TIMING.coordinator_s + 2.0


def test_it_is_not_given_up_while_a_robot_moves_in_its_turn() -> None:
    assert raised_at_s(last_moved_s=7.0) is None
