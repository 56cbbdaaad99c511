"""A robot's turn where obstacles move: how long it looks for a way before it counts as blocked."""

from typing import cast

import msgspec
import numpy as np
import pytest

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command
from agents.liveness.timing import PATIENCE_S
from agents.membership.joining import Joining
from agents.membership.turn import TurnTaker
from agents.navigation.step import NoStep
from protocol.fence import Fence
from protocol.frames import Point, Pose
from protocol.wire.messages import Odometry, Phase
from protocol.wire.view import Join
from world.scenario.scenario import load

MISSION = msgspec.structs.replace(load("grove").mission(), obstacle_speed_mps_max=0.5)
LOOK_S = 0.1
FOR_EVER_S = 60.0


class Stands:
    """A body that stands, and sees the same in every scan."""

    standing = True
    progress_m = 0.0
    position = np.zeros(2)
    odometry = Odometry(
        n=1,
        t_s=0.0,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        moving=False,
        finished=0,
        fence=Fence(),
        phase=Phase.RUNNING,
    )

    def begin(self, *_: object) -> None:
        pass

    def take(self) -> "Stands":
        return self

    def ask(self, _: float) -> list[Command]:
        return []


class NoWay:
    """What it plans: nothing."""

    def begin(self, *_: object, **__: object) -> None:
        pass

    def plan(self, *_: object) -> NoStep:
        return NoStep("no way")


def turn_s(waiting: int, body: Stands, plans: NoWay) -> float:
    """How long the turn of a robot lasts that gets to no place, beside so many that wait for theirs."""
    others = tuple(Point(x_m=float(number), y_m=0.0) for number in range(1, waiting + 1))
    strand, robots = (Point(x_m=-1.0, y_m=0.0),), tuple(range(2, waiting + 3))
    join = Join(turn=1, strand=strand, waiting=others, robots=robots, line=(), last_leg=0)
    driver, senses, joining = cast("Driver", body), cast("Senses", body), cast("Joining", plans)
    turn = TurnTaker(MISSION, driver, senses, joining, join, life=1)
    now_s = 0.0
    while turn.ended is None and now_s < FOR_EVER_S:
        turn.act(now_s)
        now_s += LOOK_S
    assert turn.ended is not None
    assert not turn.ended.placed
    return now_s - LOOK_S


@pytest.mark.parametrize("waiting", [0, 1, 3, 7])
def test_robots_that_wait_for_a_turn_share_the_time_in_which_each_looks_for_a_way(waiting: int) -> None:
    assert turn_s(waiting, Stands(), NoWay()) == pytest.approx(PATIENCE_S / (1 + waiting), abs=2 * LOOK_S)
