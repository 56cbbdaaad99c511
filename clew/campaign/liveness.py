"""Checks that a fleet healed and arrived once its faults were over. Pure: returns a sentence if it did not.

Rule 1: the healthy core are the robots that are alive at the end and have no permanent fault. When all other
        faults are over, they must be in one strand within `HEAL_S_MAX`, and must arrive.
Rule 2: dead bodies stand where they died. If they leave one robot of the core no sure way to the goal,
        nothing is checked: all robots may have to stay, or to report that there is no way.
Rule 3: a way is sure if the full map shows it with `SPARE_M` to spare on both sides. A robot that stands
        nearer to something may first drive straight to such a way, if it comes no nearer to anything.
"""

import math
from collections.abc import Iterable, Sequence

import numpy as np
from scipy import ndimage

from protocol.arrays import Flags, Floats, distances_to_segments
from protocol.keys import robot_number
from protocol.timeline import Entry, FaultInjected, RobotArrived, StrandFormed
from world.core import HEAL_S_MAX, World
from world.geometry.clearance import clearance
from world.scenario.scenario import Scenario

CELL_M = 0.03  # a fifth of the radius of a swarm's robots
SPARE_M = 0.05
NEAR_M = 0.25  # a robot that stands near something may find the sure way a little beside it
ASKEW_M = 0.001  # no cell lies exactly sideways: even the best may come half a millimetre nearer


def liveness_failure(
    world: World, entries: Iterable[tuple[str, Entry]], *, quiet_s: float, outside: frozenset[int]
) -> str | None:
    """What the fleet failed to do, in a sentence; None where it did not fail.

    Args:
        world: the world of a run that is over.
        entries: the run's timeline.
        quiet_s: when all faults were over, except for permanent ones.
        outside: the robots with a permanent fault.
    """
    entries = list(entries)
    core = sorted(world.survivors - outside - just_killed(entries))
    if not core:
        return None
    arrived = arrived_together(entries, core)
    healed_s = None if world.over_s < quiet_s else healed_at_s(entries, core, quiet_s)
    if healed_s is not None and arrived:
        healed_s = min(healed_s, world.over_s)  # the run ended before the time to heal was up
    late = healed_s is not None and healed_s - quiet_s > HEAL_S_MAX
    if arrived and not late:
        return None
    if not all_have_way(world.scenario, world.bodies.place_m, core):
        return None
    if late:
        return f"all faults were over at t={quiet_s:.1f} s, and there was one strand at t={healed_s:.1f} s"
    who = ", ".join(f"r{robot}" for robot in core if robot not in world.tally.arrived)
    return f"there was a way, and the run ended before {who} arrived: {world.ending}"


def arrived_together(entries: Iterable[tuple[str, Entry]], core: Sequence[int]) -> bool:
    """Whether the whole core was at the goal at the same time. A robot outside it may still join later."""
    there: set[int] = set()
    for source, entry in entries:
        robot = robot_number(source)
        match entry.record:
            case RobotArrived() if robot is not None:
                there.add(robot)
                if there.issuperset(core):
                    return True
            case StrandFormed() if robot is not None:
                there.discard(robot)
            case _:
                pass
    return False


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
    formed: dict[int, StrandFormed] = {}
    for source, entry in sorted(entries, key=lambda each: each[1].t_s):
        robot = robot_number(source)
        if robot is None or not isinstance(entry.record, StrandFormed):
            continue
        if entry.t_s >= quiet_s and _is_one(formed, core):
            return quiet_s
        formed[robot] = entry.record
        if entry.t_s >= quiet_s and _is_one(formed, core):
            return entry.t_s
    return quiet_s if _is_one(formed, core) else math.inf


def _is_one(formed: dict[int, StrandFormed], core: Sequence[int]) -> bool:
    strands = [formed.get(robot) for robot in core]
    first = strands[0]
    return first is not None and all(
        each is not None and each.epoch == first.epoch and set(core) <= set(each.order) for each in strands
    )


def all_have_way(scenario: Scenario, places_m: Floats, core: Sequence[int]) -> bool:
    """Whether each robot of the core has a sure way from its place in `(n, 2)` (rules 2 and 3)."""
    bodies_m = np.array([place for row, place in enumerate(places_m) if row + 1 not in core]).reshape(-1, 2)
    free, xs_m, ys_m = _free_cells(scenario, bodies_m)
    if scenario.goal is None:
        return True
    labels, _ = ndimage.label(free)
    grid_x_m, grid_y_m = np.meshgrid(xs_m, ys_m)
    goal_m, tolerance_m = scenario.goal.at_m, scenario.goal.tolerance_m
    at_goal = free & (np.hypot(grid_x_m - goal_m[0], grid_y_m - goal_m[1]) <= tolerance_m)
    reached = set(np.unique(labels[at_goal]).tolist())
    for robot in core:
        at_m = places_m[robot - 1]
        near = free & (np.hypot(grid_x_m - at_m[0], grid_y_m - at_m[1]) <= NEAR_M)
        cells_m = np.stack([grid_x_m[near], grid_y_m[near]], axis=-1)
        begins = _comes_no_nearer(scenario, bodies_m, at_m, cells_m)
        if not reached.intersection(np.unique(labels[near][begins]).tolist()):
            return False
    return True


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
