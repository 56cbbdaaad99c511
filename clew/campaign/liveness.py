"""Checks that a fleet healed and arrived once its faults were over. Pure: returns a sentence if it did not.

Rule 1: the healthy core are the robots that are alive at the end and have no permanent fault. When all other
        faults are over, they must be in one strand within `HEAL_S_MAX`, and must arrive.
Rule 2: dead bodies stand where they died. A robot of the core to which they leave no sure way to the goal
        may be stranded: the others go on without it, and it stands as well.
        A live robot with a permanent fault may stand in the way, too, and how soon it goes is a matter of
        chance. A robot of the core that it locks in when all other faults are over is not asked to arrive.
Rule 3: a way is sure if the full map shows it with `SPARE_M` to spare on both sides. A robot that stands
        nearer to something may first drive straight to such a way, if it comes no nearer to anything.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from protocol.arrays import Flags, Floats, distances_to_segments
from protocol.keys import robot_number
from protocol.timeline import (
    Entry,
    FaultInjected,
    PoseSampled,
    RobotArrived,
    RobotStranded,
    StrandJoined,
)
from world.core import HEAL_S_MAX, World
from world.geometry.clearance import clearance
from world.judge.truth.voices import concerned
from world.scenario.scenario import Scenario

CELL_M = 0.03  # a fifth of the radius of a swarm's robots
SPARE_M = 0.05
NEAR_M = 0.25  # a robot that stands near something may find the sure way a little beside it
ASKEW_M = 0.001  # no cell lies exactly sideways: even the best may come half a millimetre nearer


@dataclass(frozen=True, slots=True, kw_only=True)
class AtEnd:
    """A fleet when its run was over."""

    scenario: Scenario
    places_m: Floats
    """Where the bodies stand (n, 2)."""
    living: frozenset[int]
    untrue: frozenset[int]
    """The robots that recorded an arrival which their poses do not show."""
    ending: str | None
    over_s: float


def at_end(world: World) -> AtEnd:
    """The fleet of a world whose run is over."""
    assert world.judgement is not None, "its run is over"
    return AtEnd(
        scenario=world.scenario,
        places_m=world.bodies.place_m,
        living=world.survivors,
        untrue=world.judgement.untrue,
        ending=world.ending,
        over_s=world.over_s,
    )


def liveness_failure(
    fleet: AtEnd, entries: Iterable[tuple[str, Entry]], *, quiet_s: float, outside: frozenset[int]
) -> str | None:
    """What the fleet failed to do, in a sentence; None where it did not fail. Poses say who has arrived.

    Args:
        fleet: where and how the run ended.
        entries: the run's timeline.
        quiet_s: when all faults were over, except for permanent ones.
        outside: the robots with a permanent fault.
    """
    entries = list(concerned(entries))
    core = sorted(fleet.living - outside - just_killed(entries))
    if not core or _is_done(fleet, entries, core, quiet_s):
        return None
    able = have_way(fleet.scenario, fleet.places_m, core)
    if outside:
        free = have_way(fleet.scenario, places_at(entries, quiet_s, fleet.places_m), core)
        able = [robot for robot in able if robot in free]
    if not able or _is_done(fleet, entries, able, quiet_s):
        return None
    why = "".join(
        f"; r{robot} is stranded: {why}" for robot, why in stranded(entries).items() if robot in able
    )
    if not arrived_together(entries, able, untrue=fleet.untrue):
        *_, there = _at_goal(entries)
        lacks = [f"r{robot}" for robot in able if robot not in there - fleet.untrue]
        who = ", ".join(lacks) or "all of them at the same time"
        return f"there was a way, and the run ended before {who} arrived: {fleet.ending}{why}"
    healed_s = healed_at_s(entries, able, quiet_s)
    return f"all faults were over at t={quiet_s:.1f} s, and there was one strand at t={healed_s:.1f} s{why}"


def _is_done(fleet: AtEnd, entries: list[tuple[str, Entry]], robots: Sequence[int], quiet_s: float) -> bool:
    """Whether these robots were in one strand in time, and arrived."""
    if not arrived_together(entries, robots, untrue=fleet.untrue):
        return False
    if fleet.over_s < quiet_s:
        return True
    healed_s = min(healed_at_s(entries, robots, quiet_s), fleet.over_s)  # the run may have ended before
    return healed_s - quiet_s <= HEAL_S_MAX


def stranded(entries: Iterable[tuple[str, Entry]]) -> dict[int, str]:
    """The robots for which their coordinator found no way at the end, and why."""
    reasons: dict[int, str] = {}
    for source, entry in entries:
        match entry.record:
            case RobotStranded(robot=robot, reason=reason):
                reasons[robot] = reason
            case StrandJoined():
                reasons.pop(robot_number(source) or 0, None)
            case _:
                pass
    return reasons


def arrived_together(
    entries: Iterable[tuple[str, Entry]], core: Sequence[int], *, untrue: frozenset[int] = frozenset()
) -> bool:
    """Whether the whole core was at the goal at the same time. A robot outside it may still join later.

    Args:
        entries: the run's timeline.
        core: the robots that should arrive.
        untrue: the robots that recorded an arrival which their poses do not show.
    """
    return not untrue.intersection(core) and any(there.issuperset(core) for there in _at_goal(entries))


def _at_goal(entries: Iterable[tuple[str, Entry]]) -> Iterator[frozenset[int]]:
    """The robots at the goal: at first, and whenever one has arrived or joined a strand anew."""
    there = frozenset[int]()
    yield there
    for source, entry in entries:
        robot = robot_number(source)
        match entry.record:
            case RobotArrived() if robot is not None:
                yield (there := there | {robot})
            case StrandJoined() if robot is not None:
                yield (there := there - {robot})
            case _:
                pass


def just_killed(entries: Iterable[tuple[str, Entry]]) -> set[int]:
    """The robots killed and not restarted. When the run ended, the world may not have missed one yet."""
    killed: set[int] = set()
    for _, entry in entries:
        match entry.record:
            case FaultInjected(fault=fault, process=process) if process is not None:
                robot = robot_number(process)
                if robot is not None and fault in {"kill", "start"}:
                    (killed.add if fault == "kill" else killed.discard)(robot)
            case _:
                pass
    return killed


def healed_at_s(entries: Iterable[tuple[str, Entry]], core: Sequence[int], quiet_s: float) -> float:
    """When, after `quiet_s`, the whole core was in one strand; infinite if it never was."""
    epochs: dict[int, int] = {}
    for source, entry in sorted(entries, key=lambda each: each[1].t_s):
        robot = robot_number(source)
        if robot is None or not isinstance(entry.record, StrandJoined):
            continue
        if entry.t_s >= quiet_s and _is_one(epochs, core):
            return quiet_s
        epochs[robot] = entry.record.epoch
        if entry.t_s >= quiet_s and _is_one(epochs, core):
            return entry.t_s
    return quiet_s if _is_one(epochs, core) else math.inf


def _is_one(epochs: dict[int, int], core: Sequence[int]) -> bool:
    """Whether all of these were last in a strand of the same epoch."""
    return set(core) <= epochs.keys() and len({epochs[robot] for robot in core}) == 1


def have_way(scenario: Scenario, places_m: Floats, core: Sequence[int]) -> list[int]:
    """The robots of the core that have a sure way while all other robots stand (rules 2 and 3)."""
    able, before = list(core), 0
    while len(able) != before:  # one that has no way stands in the way of others
        before, able = len(able), _with_way(scenario, places_m, able)
    return able


def places_at(entries: Iterable[tuple[str, Entry]], t_s: float, places_m: Floats) -> Floats:
    """Where all bodies were at a time (n, 2); where they are at the end, for those not sampled before."""
    then_m = places_m.copy()
    for _, entry in sorted(entries, key=lambda each: each[1].t_s):
        match entry.record:
            case PoseSampled() as pose if entry.t_s <= t_s:
                then_m[pose.robot - 1] = pose.x_m, pose.y_m
            case _:
                pass
    return then_m


def _with_way(scenario: Scenario, places_m: Floats, core: Sequence[int]) -> list[int]:
    """The robots of the core that have a sure way from their places in `(n, 2)`."""
    from scipy import ndimage  # noqa: PLC0415 - late: a player that never asks starts in two thirds of the time

    bodies_m = np.array([place for row, place in enumerate(places_m) if row + 1 not in core]).reshape(-1, 2)
    free, xs_m, ys_m = _free_cells(scenario, bodies_m)
    if scenario.goal is None:
        return list(core)
    labels, _ = ndimage.label(free)
    grid_x_m, grid_y_m = np.meshgrid(xs_m, ys_m)
    goal_m, tolerance_m = scenario.goal.at_m, scenario.goal.tolerance_m
    at_goal = free & (np.hypot(grid_x_m - goal_m[0], grid_y_m - goal_m[1]) <= tolerance_m)
    reached = set(np.unique(labels[at_goal]).tolist())
    able = []
    for robot in core:
        at_m = places_m[robot - 1]
        near = free & (np.hypot(grid_x_m - at_m[0], grid_y_m - at_m[1]) <= NEAR_M)
        cells_m = np.stack([grid_x_m[near], grid_y_m[near]], axis=-1)
        begins = _comes_no_nearer(scenario, bodies_m, at_m, cells_m)
        if reached.intersection(np.unique(labels[near][begins]).tolist()):
            able.append(robot)
    return able


def _free_cells(scenario: Scenario, bodies_m: Floats) -> tuple[Flags, Floats, Floats]:
    """The cells where a robot's centre has `SPARE_M` to spare, as `(y, x)`, and the cells' x and y."""
    assert scenario.bounds is not None, "a swarm's fields have bounds"
    bounds, hull_m, keep_m = scenario.bounds, scenario.fleet.robot_radius_m, scenario.closest_m + SPARE_M
    xs_m = np.arange(bounds.x_m_min + hull_m, bounds.x_m_max - hull_m, CELL_M)
    ys_m = np.arange(bounds.y_m_min + hull_m, bounds.y_m_max - hull_m, CELL_M)
    cells_m = np.stack(np.meshgrid(xs_m, ys_m), axis=-1).reshape(-1, 2)
    free = _off_m(scenario, bodies_m, cells_m, cells_m) >= keep_m
    return free.reshape(len(ys_m), len(xs_m)), xs_m, ys_m


def _comes_no_nearer(scenario: Scenario, bodies_m: Floats, at_m: Floats, cells_m: Floats) -> Flags:
    """The cells that the robot reaches straight without coming nearer to anything (rule 3)."""
    starts = np.broadcast_to(at_m, cells_m.shape)
    stands_m, comes_m = (_off_m(scenario, bodies_m, starts, ends) for ends in (starts, cells_m))
    return np.asarray(comes_m >= np.minimum(stands_m, scenario.closest_m + SPARE_M) - ASKEW_M)


def _off_m(scenario: Scenario, bodies_m: Floats, starts: Floats, ends: Floats) -> Floats:
    """Distances from straight moves `(n, 2)` of a robot's centre to all obstacles and bodies' hulls."""
    off_m = clearance(scenario.ground, starts, ends)
    for body_m in bodies_m:
        hull_off_m = distances_to_segments(body_m, starts, ends) - scenario.fleet.robot_radius_m
        off_m = np.minimum(off_m, hull_off_m)
    return off_m
