"""The relations that a scenario must satisfy; each refusal is one line: path, bound, value."""

import math
from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import NamedTuple, NoReturn

import numpy as np

from protocol.frames import SPEED_MPS_MAX, Point, Pose
from protocol.legs import PLACE_SLACK_M, leg_m_min, legs_m
from protocol.mission import DRIVE_SHARE, Bounds, Mission
from world.geometry.clearance import distances
from world.geometry.movers import Movers
from world.geometry.moving import Moving
from world.geometry.shapes import Ground, Polygon, Shape, ground_of
from world.scenario.budget import Budget
from world.scenario.sections import DriveSection, Fleet, Goal, LawSection, SensorSection

GOAL = "goal.at_m"
CLOSEST = "fleet.robot_radius_m + law.epsilon_m"
"""How near a robot's centre may come to an obstacle; each of the two may be what is wrong."""
ROUNDING_M = 1e-9
"""The error of places computed by sine and cosine: a million times the last bit of a metre."""
ROUNDING_MPS = 1e-9
"""The error of a leg's length divided by its time, likewise for speeds of some m/s."""
NO_ROOM_HINT = ": use fewer robots (-n), or --deployment random"
"""What helps where a queue has no room behind its first robot."""


def _refuse(path: str, rule: str, got: object, hint: str = "") -> NoReturn:
    said = f"{got:.6g}" if isinstance(got, float) else str(got)
    raise ValueError(f"$.{path}: must be {rule}, got {said}{hint}")


class _Stand(NamedTuple):
    """A place where a robot must be able to stand, with its path in the scenario file."""

    path: str
    place: Pose | Point
    hint: str = ""
    """What helps where it is refused."""

    def refuse(self, rule: str, got: str) -> NoReturn:
        _refuse(self.path, rule, got, self.hint)


def speeds(drive: DriveSection) -> None:
    """Equation (1): v_min < v < v_max."""
    if not drive.speed_mps_min < drive.speed_mps < drive.speed_mps_max:
        _refuse(
            "drive.speed_mps",
            f"> speed_mps_min = {drive.speed_mps_min:g} and < speed_mps_max = {drive.speed_mps_max:g} m/s",
            drive.speed_mps,
        )


def law(section: LawSection) -> None:
    """The tolerance is smaller than the clearance: otherwise contact would be allowed."""
    if section.mu0_m >= section.epsilon_m:
        _refuse("law.mu0_m", f"< epsilon_m = {section.epsilon_m:g} m", section.mu0_m)


def fleet(section: Fleet) -> None:
    """Places are given in exactly one way, and for every robot."""
    queued = (section.start is not None, section.spacing_m is not None)
    if (section.places is not None) == any(queued) or any(queued) != all(queued):
        said = [name for name in ("places", "start", "spacing_m") if getattr(section, name) is not None]
        rule = "placed either by places, or by start and spacing_m, or at random"
        _refuse("fleet", rule, " and ".join(said) or "neither")
    if section.places is not None and len(section.places) < section.robots:
        _refuse("fleet.robots", f"<= the number of places = {len(section.places)}", section.robots)


def table(rows: Sequence[Sequence[float]] | None, obstacles: int, positions: int | None) -> None:
    """A reference table has a row for each switching position and a column for each obstacle."""
    if rows is None:
        return
    if positions != len(rows):
        _refuse("table_m", f"as many rows as switching_positions_max = {positions}", len(rows))
    for index, row in enumerate(rows):
        if len(row) != obstacles:
            _refuse(f"table_m[{index}]", f"as many distances as obstacles = {obstacles}", len(row))


def tracks(moving: Sequence[Moving], speed_mps_max: float | None) -> None:
    """Moving obstacles have different names, increasing times, and no leg above the top speed."""
    most_mps = SPEED_MPS_MAX if speed_mps_max is None else speed_mps_max
    rule = f"no faster than {'' if speed_mps_max is None else 'obstacle_speed_mps_max = '}{most_mps:g} m/s"
    for index, each in enumerate(moving):
        path = f"moving[{index}]"
        if each.id in {other.id for other in moving[:index]}:
            _refuse(f"{path}.id", "another than those before it", repr(each.id))
        for place, (one, other) in enumerate(pairwise(each.track), start=1):
            if other[0] <= one[0]:
                _refuse(f"{path}.track[{place}]", f"later than t = {one[0]:g} s", f"t = {other[0]:g} s")
        if each.speed_mps_max > most_mps + ROUNDING_MPS:
            _refuse(f"{path}.track", rule, f"{each.speed_mps_max:.6g} m/s")


def sight(sensor: SensorSection, rays: int, range_m_used: float, closest_m: float) -> None:
    """The sensor is sure to see every obstacle in time: at twice the distance to keep from it."""
    if sensor.range_m_max <= closest_m:
        _refuse("sensor.range_m_max", f"> {CLOSEST} = {closest_m:g} m", sensor.range_m_max)
    # To move at all, a disc of radius r + epsilon needs sight beyond itself: this is as much again.
    if range_m_used < 2.0 * closest_m:
        raise ValueError(
            f"$.sensor: must be sure of every obstacle out to 2 ({CLOSEST}) = {2.0 * closest_m:g} m, "
            f"got {range_m_used:.6g} m with {rays} directions"
        )


def errors_covered(section: LawSection, errors: Budget) -> None:
    """The error budget: mu0 covers every difference between promised and true clearance."""
    if section.mu0_m < errors.total_m:
        _refuse(
            "law.mu0_m",
            f">= {errors.total_m:.6g} m, which is ray quantisation {errors.quantisation_m:.6g} m"
            f" + range noise {errors.range_noise_m:.6g} m + drive {errors.drive_m:.6g} m"
            f" + rounding {errors.rounding_m:.6g} m",
            section.mu0_m,
        )


def no_hull_is_anothers(section: Fleet, mission: Mission) -> None:
    """What a robot takes out of its scan as the hull of a neighbour is that hull (F6 of docs/strand.md).

    It takes out hits within `hull_reach_m` of where the neighbour is, which may be as near as
    `epsilon - mu0` to an obstacle, and as near as `separation - mu0` to a robot that is left out.
    """
    least_m = 2.0 * mission.mu0_m + mission.range_error_m_max
    if section.robots == 1 or mission.robot_radius_m == 0.0 or not mission.promises_clearance:
        return
    for path, kept_m, otherwise in (
        ("law.epsilon_m", mission.epsilon_m, "obstacles count as robots"),
        ("fleet.separation_m", mission.separation_m, "a robot counts as another"),
    ):
        if kept_m < least_m - ROUNDING_M:
            _refuse(path, f">= 2 mu0_m + range error = {least_m:g} m: else {otherwise}", kept_m)


def legs(section: Fleet, mission: Mission) -> None:
    """There are places at which a robot can join a strand: else one that is left out searches in vain."""
    if section.robots == 1 or not mission.promises_clearance:
        return
    if len(legs_m(mission)) > 0:
        return
    least_m, most_m = leg_m_min(mission) + PLACE_SLACK_M, mission.leg_m_max
    speed_mps = mission.obstacle_speed_mps_max
    least = f"{least_m:.4g} m, the least way between neighbours"
    least += f" where obstacles move at {speed_mps:g} m/s" if speed_mps else ""
    if section.link_length_m_max < least_m:
        _refuse("fleet.link_length_m_max", f">= {least}", section.link_length_m_max)
    if most_m < least_m:
        _refuse("sensor", f"sure of {least}", f"{most_m:.4g} m")
    rule = f"more: on every way of up to {most_m:.4g} m the robot ahead hides what is beside its place"
    _refuse("law.epsilon_m", rule, mission.epsilon_m)


def said(bounds: Bounds | None) -> Bounds:
    """A random deployment needs bounds."""
    if bounds is None:
        _refuse("bounds", "said for a random deployment", "none")
    return bounds


def places_apart(section: Fleet, poses: Sequence[Pose], mission: Mission) -> None:
    """No two robots start nearer to each other than their separation, or so near that neither may move."""
    least_m = 2.0 * section.robot_radius_m + section.separation_m
    rule = f">= 2 robot_radius_m + separation_m = {least_m:g} m"
    if mission.moves_beside_m > least_m:
        least_m, speed_mps = mission.moves_beside_m, mission.obstacle_speed_mps_max
        rule = (
            f">= {least_m:.4g} m: nearer to one that may hide an obstacle of {speed_mps:g} m/s, none can move"
        )
    if section.spacing_m is not None:  # places on one line: the spacing is their least distance
        if len(poses) > 1 and section.spacing_m < least_m - ROUNDING_M:
            _refuse("fleet.spacing_m", rule, section.spacing_m)
        return
    for (i, one), (j, other) in combinations(enumerate(poses), 2):
        apart_m = float(np.hypot(one.x_m - other.x_m, one.y_m - other.y_m))
        if apart_m < least_m - ROUNDING_M:
            _refuse(f"fleet.places[{j}]", f"{rule} from places[{i}]", f"{apart_m:.6g} m at {_at(other)}")


def within(bounds: Bounds | None, section: Fleet, poses: Sequence[Pose], goal: Goal | None) -> None:
    """Every robot's hull is inside the bounds at its start, and at the goal."""
    if bounds is None:
        return
    for name, low_m, high_m in (("x", bounds.x_m_min, bounds.x_m_max), ("y", bounds.y_m_min, bounds.y_m_max)):
        if low_m >= high_m:
            _refuse(f"bounds.{name}_m_min", f"< {name}_m_max = {high_m:g} m", low_m)
    radius_m = section.robot_radius_m
    for stand in _stands(section, poses, goal):
        place = stand.place
        for axis, at_m, low_m, high_m in (
            ("x", place.x_m, bounds.x_m_min, bounds.x_m_max),
            ("y", place.y_m, bounds.y_m_min, bounds.y_m_max),
        ):
            rule = "inside the bounds by the radius, at"
            if at_m - low_m < radius_m - ROUNDING_M:
                least = f"{axis} >= {axis}_m_min + {radius_m:g} = {low_m + radius_m:g} m"
                stand.refuse(f"{rule} {least}", _at(place))
            if high_m - at_m < radius_m - ROUNDING_M:
                most = f"{axis} <= {axis}_m_max - {radius_m:g} = {high_m - radius_m:g} m"
                stand.refuse(f"{rule} {most}", _at(place))


def room_for_path(bounds: Bounds | None, mission: Mission) -> None:
    """The bounds leave room for a strand's path on both sides, also between two of them.

    Robots of a queue drive along it even where the leader has no room for a step.
    """
    if bounds is None or (laid := mission.path_bounds) is None:
        return
    for name, low_m, from_m, to_m in (
        ("x", bounds.x_m_min, laid.x_m_min, laid.x_m_max),
        ("y", bounds.y_m_min, laid.y_m_min, laid.y_m_max),
    ):
        if to_m - from_m < -ROUNDING_M:
            most_m = low_m - (from_m - to_m)
            rule = f"<= {name}_m_max - 2 (robot_radius_m + mu0_m / 4) = {most_m:g} m"
            _refuse(f"bounds.{name}_m_min", rule, low_m)


def near_path(section: Fleet, poses: Sequence[Pose], mission: Mission, budget: Budget) -> None:
    """No start is so far in a corner of the bounds that a drive along the strand's path leaves the seen leg.

    The path keeps off the bounds by one drive's share of mu0, and legs leave room for two such shares
    (`agents/coordinating/formation.py`); in a corner a start may be off the path by more than one.
    """
    if (laid := mission.path_bounds) is None:
        return
    room_m = (2.0 * mission.mu0_m - budget.drive_m) * DRIVE_SHARE
    for stand in _stands(section, poses, None):
        place = stand.place
        near = laid.nearest(place)
        if math.hypot(place.x_m - near.x_m, place.y_m - near.y_m) > room_m + ROUNDING_M:
            rule = f"within {room_m:.6g} m of {_at(near)}, out of the corner of the bounds"
            stand.refuse(rule, _at(place))


def clear_of(
    shapes: Sequence[Shape],
    ground: Ground,
    section: Fleet,
    poses: Sequence[Pose],
    goal: Goal | None,
    *,
    standoff_m: float,
) -> None:
    """No place or goal is in an obstacle, or nearer to one than `standoff_m`; `ground` has all shapes packed.

    A goal may be nearer by its tolerance, since the leader may stop that much before it.
    """
    if ground.shape_count == 0:
        return
    for stand in _stands(section, poses, goal):
        place = stand.place
        apart_m = distances(ground, np.array((place.x_m, place.y_m)))
        nearest = int(apart_m.argmin())
        spare_m = goal.tolerance_m if goal is not None and stand.path == GOAL else 0.0
        if apart_m[nearest] < standoff_m - spare_m - ROUNDING_M or apart_m[nearest] == 0.0:
            how_near = "inside it" if apart_m[nearest] == 0.0 else f"{apart_m[nearest]:.6g} m"
            rule = f">= {max(standoff_m - spare_m, 0.0):g} m away from $.obstacle[{nearest}]"
            rule += f" ({_found(shapes[nearest])})"
            stand.refuse(rule, f"{how_near} at {_at(place)}")


def untouched(movers: Movers, section: Fleet, poses: Sequence[Pose]) -> None:
    """No robot starts in contact with a moving obstacle at its place at t = 0."""
    ground = movers.among(ground_of(()), 0.0)
    for stand in _stands(section, poses, None) if movers.names else ():
        place = stand.place
        apart_m = distances(ground, np.array((place.x_m, place.y_m)))
        nearest = int(apart_m.argmin())
        if apart_m[nearest] <= section.robot_radius_m:
            rule = f"> robot_radius_m = {section.robot_radius_m:g} m away from $.moving[{nearest}] at t = 0 s"
            stand.refuse(rule, f"{apart_m[nearest]:.6g} m at {_at(place)}")


def _stands(section: Fleet, poses: Sequence[Pose], goal: Goal | None) -> list[_Stand]:
    """All places where a robot must be able to stand."""
    stands = [
        _Stand(
            f"fleet.{'start' if section.places is None else f'places[{k}]'}, place of robot {k + 1}",
            pose,
            NO_ROOM_HINT if section.places is None and k > 0 else "",
        )
        for k, pose in enumerate(poses)
    ]
    return stands if goal is None else [*stands, _Stand(GOAL, Point(x_m=goal.at_m[0], y_m=goal.at_m[1]))]


def _found(shape: Shape) -> str:
    """How to find a shape in a file that has hundreds."""
    if isinstance(shape, Polygon):
        x_m, y_m = shape.vertices_m[0]
        return f"the polygon from ({x_m:.6g}, {y_m:.6g})"
    x_m, y_m = shape.centre_m
    return f"the {type(shape).__name__.lower()} at ({x_m:.6g}, {y_m:.6g})"


def _at(place: Pose | Point) -> str:
    return f"({place.x_m:.6g}, {place.y_m:.6g})"
