"""A lawful run of three robots, entry by entry, and the same run with other entries.

Robot 2 coordinates epoch 10002. Robot 3 joins in turn 1, at x = -1.2 m. From turn 3 on the strand of robots
1, 2 and 3 drives along the x axis, on which arc length is x + 1.2 m. Robot 1 leads a step. It stops on its
way, as robot 3 proposes epoch 20003. Nobody has to join there, so ALL is turn 1.
"""

from functools import partial

from msgspec.structs import replace

from protocol.fence import Cause, May
from protocol.frames import Point
from protocol.timeline import (
    AuthorityGranted,
    FenceChanged,
    OrderAccepted,
    PoseSampled,
    PromiseBroken,
    RobotStarted,
    ScanServed,
    StepPlanned,
    StrandFormed,
    StrandJoined,
    ViewJoined,
    ViewProposed,
)
from tests.support.histories.entries import Said, changed, lines_of
from tests.support.planned import planned
from world.judge.judgement import Court
from world.judge.rules.motion import Tolerance

FIRST = 10_002  # generation 1, robot 2
SECOND = 20_003
LIVES = {1: "1a", 2: "2b", 3: "3c", 4: "4d"}
EXACT = Tolerance(mu0_m=0.01, heading_error_rad=0.0, speed_mps_max=1.0)


def fence(
    epoch: int,
    turn: int,
    may: May = May.NOBODY,
    *,
    named: int = 0,
    members: int = 0,
    cause: Cause | None = None,
) -> FenceChanged:
    coordinator = epoch % 10_000
    return FenceChanged(
        epoch=epoch,
        turn=turn,
        may=may,
        coordinator=coordinator,
        life=LIVES.get(coordinator, ""),
        named=named,
        named_life=LIVES[named] if may is May.ONE else "",
        members=members,
        cause=cause,
    )


def pose(robot: int, x_m: float, y_m: float = 0.0) -> PoseSampled:
    return PoseSampled(robot=robot, x_m=x_m, y_m=y_m, heading_rad=0.0)


def scan(robot: int) -> ScanServed:
    return ScanServed(robot=robot, x_m=0.0, y_m=0.0, heading_rad=0.0, revolutions=1, hits=0)


def order(
    robot: int,
    from_m: tuple[float, float],
    to_m: tuple[float, float] | None,
    *,
    epoch: int = FIRST,
    turn: int = 3,
    life: str | None = None,
    step: int = 0,
    reach_m: float = 0.0,
) -> OrderAccepted:
    return OrderAccepted(
        robot=robot,
        number=1,
        epoch=epoch,
        turn=turn,
        life=LIVES[robot] if life is None else life,
        step=step,
        x_m=from_m[0],
        y_m=from_m[1],
        target=None if to_m is None else Point(x_m=to_m[0], y_m=to_m[1]),
        reach_m=reach_m,
    )


def plan(
    x_m: float, y_m: float = 0.0, *, step: int = 1, epoch: int = FIRST, joins: bool = False
) -> StepPlanned:
    return replace(
        planned(step),
        epoch=epoch,
        length_m=0.0,
        target=Point(x_m=x_m, y_m=y_m),
        reach_m=0.0,
        joins=joins,
    )


def grant(authority_m: float, *, to: int = 2, epoch: int = FIRST) -> AuthorityGranted:
    return AuthorityGranted(to=to, epoch=epoch, authority_m=authority_m)


def formation(epoch: int, turn: int, *places_m: float, order: tuple[int, ...] = (1, 2, 3)) -> StrandFormed:
    return StrandFormed(
        epoch=epoch,
        turn=turn,
        order=order,
        lives=tuple(LIVES[robot] for robot in order),
        places_m=places_m,
        laid=(Point(x_m=-1.2, y_m=0.0), Point(x_m=places_m[0] - 1.2, y_m=0.0)),
        driven=(False,) * len(order),
        back_by_m=0.0,
        sensed=False,
    )


RUN: dict[str, Said] = {
    "place 1": (0.0, "world", pose(1, 0.0)),
    "place 2": (0.0, "world", pose(2, -0.6)),
    "place 3": (0.0, "world", pose(3, -1.0, 0.5)),
    "start 1": (0.0, "r1", RobotStarted(pid=1)),
    "start 2": (0.0, "r2", RobotStarted(pid=2)),
    "start 3": (0.0, "r3", RobotStarted(pid=3)),
    "proposed": (0.1, "r2", ViewProposed(epoch=FIRST, cause=Cause.START, why="the run begins")),
    "raised": (0.2, "world", fence(FIRST, 0, cause=Cause.START)),
    "joined 1": (0.3, "r1", ViewJoined(epoch=FIRST)),
    "joined 2": (0.3, "r2", ViewJoined(epoch=FIRST)),
    "joined 3": (0.3, "r3", ViewJoined(epoch=FIRST)),
    "turn 1": (0.4, "world", fence(FIRST, 1, May.ONE, named=3)),
    "scan 3": (0.5, "world", scan(3)),
    "plan 3": (0.55, "r3", plan(-1.2, joins=True)),
    "order 3": (0.6, "world", order(3, (-1.0, 0.5), (-1.2, 0.0), turn=1)),
    "drive 3": (0.6, "world", pose(3, -1.0, 0.5)),
    "there 3": (1.6, "world", pose(3, -1.2)),
    "turn 2": (1.8, "world", fence(FIRST, 2)),
    "formed": (1.9, "r2", formation(FIRST, 3, 1.2, 0.6, 0.0)),
    "all": (2.0, "world", fence(FIRST, 3, May.ALL, named=1, members=3)),
    "rank 1": (2.1, "r1", StrandJoined(epoch=FIRST, rank=0)),
    "rank 2": (2.1, "r2", StrandJoined(epoch=FIRST, rank=1)),
    "rank 3": (2.1, "r3", StrandJoined(epoch=FIRST, rank=2)),
    "scan 1": (2.2, "world", scan(1)),
    "plan 1": (2.3, "r1", plan(1.0)),
    "order 1": (2.32, "world", order(1, (0.0, 0.0), (1.0, 0.0), step=1, reach_m=2.2)),
    "drive 1": (2.32, "world", pose(1, 0.0)),
    "scan 2": (2.4, "world", scan(2)),
    "grant 2": (2.9, "r1", grant(1.0)),
    "order 2": (2.92, "world", order(2, (-0.6, 0.0), (-0.2, 0.0), reach_m=1.0)),
    "drive 2": (2.92, "world", pose(2, -0.6)),
    "there 2": (3.72, "world", pose(2, -0.2)),
    "there 1": (3.92, "world", pose(1, 0.8)),
    "proposed again": (3.9, "r3", ViewProposed(epoch=SECOND, cause=Cause.PLEA, why="robot 4 asks")),
    "raised again": (3.92, "world", fence(SECOND, 0, cause=Cause.PLEA)),
    "joined 1 again": (4.0, "r1", ViewJoined(epoch=SECOND)),
    "formed again": (4.4, "r3", formation(SECOND, 1, 2.0, 1.0, 0.0)),
    "all again": (4.5, "world", fence(SECOND, 1, May.ALL, named=1, members=3)),
    "scan 1 again": (4.55, "world", scan(1)),
    "plan 1 again": (4.6, "r1", plan(1.0, step=2, epoch=SECOND)),
    "order 1 again": (
        4.62,
        "world",
        order(1, (0.8, 0.0), (1.0, 0.0), epoch=SECOND, turn=1, step=2, reach_m=2.2),
    ),
    "drive 1 again": (4.62, "world", pose(1, 0.8)),
    "there 1 again": (5.02, "world", pose(1, 1.0)),
}


run = partial(changed, RUN)
"""The lawful run in order of time, but for this."""


def breaches(
    said: list[Said], tolerance: Tolerance = EXACT, *, followers_sense: bool = True, cut_off: bool = False
) -> list[tuple[float, PromiseBroken]]:
    """What is broken in a run, but for S1 and S2."""
    court = Court(tolerance, followers_sense=followers_sense)
    for source, entry in lines_of(said):
        court.hear(source, entry)
    court.close(cut_off=cut_off)
    return [(breach.t_s, breach.broken) for breach in court.breaches]


def broken(said: list[Said], tolerance: Tolerance = EXACT, *, followers_sense: bool = True) -> list[str]:
    """The names of the invariants that a run breaks, once per violation, sorted."""
    found = breaches(said, tolerance, followers_sense=followers_sense)
    return sorted(breach.invariant for _, breach in found)
