"""A robot's turn where obstacles move: how long it looks for a way before it counts as blocked."""

from typing import cast

import msgspec
import numpy as np
import pytest

from agents.body.driver import Driver
from agents.body.senses import Senses
from agents.commands import Command
from agents.membership.joining import Joining
from agents.membership.turn import PATIENCE_S, TurnTaker
from agents.navigation.step import NoStep
from protocol.frames import Point
from protocol.timeline import StepPlanned
from protocol.wire.view import Join
from world.scenario.scenario import load

MISSION = msgspec.structs.replace(load("grove").mission(), obstacle_speed_mps_max=0.5)
LOOK_S = 0.1
FOR_EVER_S = 60.0
APART_M = 0.088  # of the places between which a robot of `dense-eight` went to and fro until the time was up


class Stands:
    """A body that stands, and sees the same in every scan."""

    standing = True
    progress_m = 0.0
    position = np.zeros(2)

    def take(self) -> "Stands":
        return self

    def ask(self, _: float) -> list[Command]:
        return []


class Obeys(Stands):
    """A body that is at once where it is sent; the next scan is from there."""

    def __init__(self) -> None:
        self.position = np.zeros(2)

    def to(self, target: Point, *, reach_m: float) -> None:
        self.position, self.progress_m = np.array([target.x_m, target.y_m]), reach_m

    def stand(self) -> None:
        pass


class ToAndFro:
    """What it plans: to go to the other one of two places."""

    way_m = 0.0

    def plan(self, scan: Obeys, _: object) -> StepPlanned:
        there_m = 0.0 if scan.position[0] > 0.0 else APART_M
        self.way_m += APART_M
        return step_to(Point(x_m=there_m, y_m=0.0), reach_m=self.way_m)


class NoWay:
    """What it plans: nothing."""

    def plan(self, *_: object) -> NoStep:
        return NoStep("no way")


def step_to(target: Point, *, reach_m: float) -> StepPlanned:
    return StepPlanned(
        step=1,
        epoch=1,
        law="certified",
        x_m=0.0,
        y_m=0.0,
        obstacles=(),
        gaps=(),
        gap=None,
        heading_rad=0.0,
        length_m=APART_M,
        target=target,
        reach_m=reach_m,
        promised_clearance_m=None,
        cost_to_go_m=None,
        joins=True,
    )


def turn_s(waiting: int, body: Stands, plans: NoWay | ToAndFro) -> float:
    """How long the turn of a robot lasts that gets to no place, beside so many that wait for theirs."""
    others = tuple(Point(x_m=float(number), y_m=0.0) for number in range(1, waiting + 1))
    join = Join(turn=1, strand=(Point(x_m=-1.0, y_m=0.0),), waiting=others, line=(), last_leg=0)
    turn = TurnTaker(MISSION, cast("Driver", body), cast("Senses", body), cast("Joining", plans), join)
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


def test_the_turn_of_a_robot_ends_that_goes_to_and_fro_between_two_places() -> None:
    assert turn_s(1, Obeys(), ToAndFro()) == pytest.approx(PATIENCE_S, abs=1.0)
