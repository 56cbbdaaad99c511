"""A strand of three robots that drives to the goal, entry by entry, and the same run with other entries.

Robot 1 coordinates epoch 10001 and leads from x = 0 to the goal at x = 1 m, in one step. Robots 2 and 3 come
up behind it, each 0.32 m behind the one ahead: two radii, the separation and mu0. Arc length is x + 1.2 m.
The leader's step comes as near as 0.381 m to a post.
"""

from collections.abc import Iterable
from functools import partial
from math import hypot

from msgspec.structs import replace

from protocol.fence import Cause, May
from protocol.frames import Point
from protocol.timeline import (
    FenceChanged,
    GoalReached,
    OrderAccepted,
    PoseSampled,
    PromiseBroken,
    RobotAppeared,
    RobotArrived,
    RobotSettled,
    RobotStarted,
    StepFinished,
    StepPlanned,
    StrandFormed,
    StrandJoined,
)
from tests.support.histories.entries import Said, changed, lines_of
from tests.support.planned import planned
from tests.support.scenes.world_scenarios import scenario
from world.judge.truth.truth import Truth
from world.scenario.scenario import Scenario

EPOCH, NEXT = 10_001, 20_002
GOAL_M = 1.0
KEEP_M = 0.32
LEFT_M = hypot(0.5, 0.6) - 0.3 - 0.1  # from the goal to the post of `scenario`
SCENE = scenario(fleet={"robots": 3}, goal={"at_m": [GOAL_M, 0.0], "tolerance_m": 0.15})


def pose(robot: int, x_m: float) -> PoseSampled:
    return PoseSampled(robot=robot, x_m=x_m, y_m=0.0, heading_rad=0.0)


def fence(epoch: int, turn: int, may: May, *, leader: int = 0) -> FenceChanged:
    return FenceChanged(
        epoch=epoch,
        turn=turn,
        may=may,
        coordinator=epoch % 10_000,
        life="a",
        named=leader,
        members=3 if leader else 0,
        cause=None if turn else Cause.START,
    )


def plan(promised_m: float | None = LEFT_M) -> StepPlanned:
    target = Point(x_m=GOAL_M, y_m=0.0)
    step = replace(planned(1), epoch=EPOCH, target=target, reach_m=2.2)
    return replace(step, promised_clearance_m=promised_m)


def order(robot: int, from_m: float, to_m: float, *, step: int = 0) -> OrderAccepted:
    return OrderAccepted(
        robot=robot,
        number=1,
        epoch=EPOCH,
        turn=1,
        life="a",
        step=step,
        x_m=from_m,
        y_m=0.0,
        target=Point(x_m=to_m, y_m=0.0),
        reach_m=to_m + 1.2,
    )


def formation(*order: int) -> StrandFormed:
    return StrandFormed(
        epoch=EPOCH,
        turn=1,
        order=order,
        lives=("a",) * len(order),
        places_m=(1.2, 0.6, 0.0),
        laid=(Point(x_m=-1.2, y_m=0.0), Point(x_m=0.0, y_m=0.0)),
        driven=(True,) * len(order),
        back_by_m=0.0,
        sensed=False,
    )


def finished(x_m: float = GOAL_M) -> StepFinished:
    return StepFinished(robot=1, step=1, x_m=x_m, y_m=0.0, clearance_m=None)


RUN: dict[str, Said] = {
    **{f"shown {robot}": (0.0, "world", RobotAppeared(robot=robot, incarnation="i")) for robot in (1, 2, 3)},
    **{f"start {robot}": (0.0, f"r{robot}", RobotStarted(pid=1, incarnation="i")) for robot in (1, 2, 3)},
    "place 1": (0.0, "world", pose(1, 0.0)),
    "place 2": (0.0, "world", pose(2, -0.6)),
    "place 3": (0.0, "world", pose(3, -1.2)),
    "raised": (0.2, "world", fence(EPOCH, 0, May.NOBODY)),
    "formed": (0.3, "r1", formation(1, 2, 3)),
    "all": (0.4, "world", fence(EPOCH, 1, May.ALL, leader=1)),
    "joined 1": (0.5, "r1", StrandJoined(epoch=EPOCH, rank=0)),
    "joined 2": (0.5, "r2", StrandJoined(epoch=EPOCH, rank=1)),
    "joined 3": (0.5, "r3", StrandJoined(epoch=EPOCH, rank=2)),
    "plan 1": (0.9, "r1", plan()),
    "order 1": (1.0, "world", order(1, 0.0, GOAL_M, step=1)),
    "drive 1": (1.0, "world", pose(1, 0.0)),
    "half 1": (2.0, "world", pose(1, 0.5)),
    "finished 1": (3.0, "world", finished()),
    "goal 1": (3.0, "r1", GoalReached(x_m=GOAL_M, y_m=0.0)),
    "arrived 1": (3.0, "r1", RobotArrived(progress_m=2.2)),
    "there 1": (3.0, "world", pose(1, GOAL_M)),  # the world samples a body that lands in its next tick
    "order 2": (3.1, "world", order(2, -0.6, GOAL_M - KEEP_M)),
    "drive 2": (3.1, "world", pose(2, -0.6)),
    "there 2": (5.7, "world", pose(2, GOAL_M - KEEP_M)),
    "arrived 2": (5.7, "r2", RobotArrived(progress_m=2.2 - KEEP_M)),
    "order 3": (5.8, "world", order(3, -1.2, GOAL_M - 2 * KEEP_M)),
    "drive 3": (5.8, "world", pose(3, -1.2)),
    "there 3": (8.9, "world", pose(3, GOAL_M - 2 * KEEP_M)),
    "arrived 3": (8.9, "r3", RobotArrived(progress_m=2.2 - 2 * KEEP_M)),
    "end 1": (9.0, "world", pose(1, GOAL_M)),
    "end 2": (9.0, "world", pose(2, GOAL_M - KEEP_M)),
    "end 3": (9.0, "world", pose(3, GOAL_M - 2 * KEEP_M)),
    "settled 1": (9.1, "r1", RobotSettled(sent={})),
    "settled 2": (9.1, "r2", RobotSettled(sent={})),
    "settled 3": (9.1, "r3", RobotSettled(sent={})),
}


run = partial(changed, RUN)
"""The lawful run in order of time, but for this."""


def breaches(said: Iterable[Said], scene: Scenario = SCENE, *, cut_off: bool = False) -> list[PromiseBroken]:
    """What the entries of robots break, by true poses."""
    truth = Truth(scene)
    found = [each for source, entry in lines_of(said) for each in truth.hear(source, entry)]
    found += truth.close()
    return [breach for _, breach in [*found, *(() if cut_off else truth.decide())]]


def broken(said: Iterable[Said], *, cut_off: bool = False) -> list[tuple[str, int]]:
    """The invariants that are broken, and by whom."""
    return [(breach.invariant, breach.robot) for breach in breaches(said, cut_off=cut_off)]
