"""Logs of a fleet that drives for any time.

`python -m tests.support.logs.driving_logs FOLDER [ENTRIES]` makes one. Five robots, one metre apart, drive
round a square around the obstacles of `grove`. A step has what it has in a real run: a scan, a plan, orders,
grants, and ten samples a second. The log keeps every promise.
"""

import sys
from collections import Counter
from collections.abc import Iterator
from itertools import count, islice
from pathlib import Path

import msgspec
from msgspec.structs import replace

from protocol.faults.plan import NO_FAULTS
from protocol.fence import Cause, May
from protocol.frames import Point
from protocol.keys import robot_name
from protocol.run_settings import Settings
from protocol.timeline import (
    AuthorityGranted,
    Entry,
    FenceChanged,
    OrderAccepted,
    OrderFinished,
    PoseSampled,
    Record,
    RobotAppeared,
    RobotStarted,
    ScanServed,
    StepFinished,
    StrandFormed,
    StrandJoined,
    ViewJoined,
)
from tests.support.planned import planned
from world.record.recorder import EVENTS_FILE, line
from world.record.run_files import header_of, prepare_folder
from world.scenario.scenario import Scenario, load
from world.scenario.sections import TimeSection

EPOCH = 10_001
SIDE_M = 12
"""Of the square; `grove` is inside."""
ORDER = (1, 2, 3, 4, 5)
STEP_S = 2.0  # a metre at 0.5 m/s
SAMPLES = 20  # in a step

Said = tuple[float, str, Record]


def scenario() -> Scenario:
    """`grove` without its bounds, with robots on the square and time for ever."""
    grove = load("grove")
    places = tuple((place.x_m, place.y_m, 0.0) for place in map(_at, range(4, -1, -1)))
    fleet = replace(grove.fleet, start=None, spacing_m=None, places=places, link_length_m_max=2.0)
    return replace(grove, bounds=None, fleet=fleet, time=TimeSection(time_s_max=1e6))


def entries(many: int) -> Iterator[tuple[str, Entry]]:
    """So many entries, in the recorder's order."""
    counts = Counter[str]()
    for t_s, source, record in islice(_said(), many):
        counts[source] += 1
        yield (
            source,
            Entry(n=counts[source], t_s=round(t_s, 2), hlc=f"{int(t_s * 2**32)}/{source}", record=record),
        )


def make(folder: Path, many: int = 1_000_000) -> Path:
    """A run's folder with a log of this many entries, from which a world can go on."""
    folder.mkdir(parents=True)
    prepare_folder(folder, scenario(), NO_FAULTS, Settings(seed=1, speed=0.01))
    started_at = "2026-11-22T00:00:00+00:00"
    header = header_of(
        scenario(), NO_FAULTS, run="long", seed=1, speed=0.01, started_at=started_at, hlc="0/world"
    )
    with (folder / EVENTS_FILE).open("wb") as file:
        file.write(msgspec.json.encode(header) + b"\n")
        for source, entry in entries(many):
            file.write(line(source, entry))
    return folder


def _said() -> Iterator[Said]:
    yield from _begin()
    for step in count(1):
        yield from _step(step, 1.0 + (step - 1) * STEP_S)


def _begin() -> Iterator[Said]:
    """The strand forms where it stands, its tail at arc length 0."""
    for robot in ORDER:
        yield 0.0, "world", RobotAppeared(robot=robot)
    for robot in ORDER:
        yield 0.0, "world", _pose(robot, _at(5 - robot))
        yield 0.0, robot_name(robot), RobotStarted(pid=robot)
    yield 0.1, "world", _fence(0, May.NOBODY, cause=Cause.START)
    for robot in ORDER:
        yield 0.2, robot_name(robot), ViewJoined(epoch=EPOCH)
    yield 0.3, "r1", _formation()
    yield 0.4, "world", _fence(1, May.ALL)
    for rank, robot in enumerate(ORDER):
        yield 0.5, robot_name(robot), StrandJoined(epoch=EPOCH, rank=rank)
        yield 0.6, "world", _scan(robot, _at(5 - robot))


def _step(step: int, t_s: float) -> Iterator[Said]:
    """All robots drive one metre on."""
    starts = {robot: 4 - rank + step - 1 for rank, robot in enumerate(ORDER)}
    yield t_s, "world", _scan(1, _at(starts[1]))
    target, reach_m = _at(starts[1] + 1), starts[1] + 1.0
    plan = replace(planned(step), epoch=EPOCH, target=target, reach_m=reach_m, promised_clearance_m=0.0)
    yield t_s, "r1", plan
    for robot in ORDER[:-1]:
        yield t_s, robot_name(robot), AuthorityGranted(to=robot + 1, epoch=EPOCH, authority_m=starts[robot])
    for robot, start in starts.items():
        yield t_s, "world", _order(robot, step, start)
        yield t_s, "world", _pose(robot, _at(start))
    for sample in range(1, SAMPLES + 1):
        for robot, start in starts.items():
            yield t_s + sample * STEP_S / SAMPLES, "world", _pose(robot, _between(start, sample / SAMPLES))
    for robot, start in starts.items():
        end = _at(start + 1)
        number, x_m, y_m = step, end.x_m, end.y_m
        led = step if robot == 1 else 0
        done = OrderFinished(robot=robot, number=number, step=led, x_m=x_m, y_m=y_m, clearance_m=1.0)
        yield t_s + STEP_S, "world", done
    at = _at(starts[1] + 1)
    yield t_s + STEP_S, "world", StepFinished(robot=1, step=step, x_m=at.x_m, y_m=at.y_m, clearance_m=1.0)


def _at(metre: int) -> Point:
    """The point at so many metres along the square, whose corner is at -4, -4."""
    side, along = divmod(metre % (4 * SIDE_M), SIDE_M)
    x_m, y_m = [(along, 0), (SIDE_M, along), (SIDE_M - along, SIDE_M), (0, SIDE_M - along)][side]
    return Point(x_m=x_m - 4.0, y_m=y_m - 4.0)


def _between(metre: int, share: float) -> Point:
    start, end = _at(metre), _at(metre + 1)
    return Point(x_m=start.x_m + share * (end.x_m - start.x_m), y_m=start.y_m + share * (end.y_m - start.y_m))


def _pose(robot: int, at: Point) -> PoseSampled:
    return PoseSampled(robot=robot, x_m=at.x_m, y_m=at.y_m, heading_rad=0.0)


def _scan(robot: int, at: Point) -> ScanServed:
    return ScanServed(robot=robot, x_m=at.x_m, y_m=at.y_m, heading_rad=0.0, revolutions=1, hits=0)


def _life(robot: int) -> str:
    return f"{100 + robot:x}"


def _fence(turn: int, may: May, *, cause: Cause | None = None) -> FenceChanged:
    drives = may is May.ALL
    return FenceChanged(
        epoch=EPOCH,
        turn=turn,
        may=may,
        coordinator=1,
        life=_life(1),
        named=1 if drives else 0,
        members=len(ORDER) if drives else 0,
        cause=cause,
    )


def _formation() -> StrandFormed:
    return StrandFormed(
        epoch=EPOCH,
        turn=1,
        order=ORDER,
        lives=tuple(map(_life, ORDER)),
        places_m=(4.0, 3.0, 2.0, 1.0, 0.0),
        laid=(_at(0), _at(4)),
        driven=(False,) * len(ORDER),
        back_by_m=0.0,
        sensed=True,
    )


def _order(robot: int, step: int, start: int) -> OrderAccepted:
    at = _at(start)
    return OrderAccepted(
        robot=robot,
        number=step,
        epoch=EPOCH,
        turn=1,
        life=_life(robot),
        step=step if robot == 1 else 0,
        x_m=at.x_m,
        y_m=at.y_m,
        target=_at(start + 1),
        reach_m=start + 1.0,
    )


if __name__ == "__main__":
    make(Path(sys.argv[1]), *map(int, sys.argv[2:]))
