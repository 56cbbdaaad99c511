"""A random deployment: places for a fleet, drawn by the run's seed.

Rule 1: the places are free, apart, and on one piece of ground: there is a way between any two of them.
Rule 2: that piece contains the scenario's place of robot 1 or, if there is none, the goal.
"""

import math
from typing import Any

import numpy as np
from msgspec import Struct, field

from protocol.errors import UsageError
from protocol.files.reading import understand
from protocol.frames import Pose
from protocol.mission import Bounds, robot_keep_m
from world.chance import stream
from world.geometry.clearance import distances
from world.geometry.movers import Movers
from world.geometry.moving import Moving, top_speed_mps
from world.geometry.shapes import Ground, Shape, ground_of
from world.scenario import checks
from world.scenario.piece import Piece, piece_of
from world.scenario.sections import Fleet, Goal, LawSection

TRIES = 10_000  # draws per robot: with one place in 1000 free, 5 robots in 100,000 find no place
SAID = ("places", "start", "spacing_m")
"""The fields of a fleet that define its places; drawn places are stored in the first one."""


class _Site(Struct, frozen=True, kw_only=True):
    """The parts of a scenario that decide where robots can stand; the scenario checks the rest."""

    fleet: Fleet
    law: LawSection
    goal: Goal | None = None
    bounds: Bounds | None = None
    obstacles: tuple[Shape, ...] = field(default=(), name="obstacle")
    moving: tuple[Moving, ...] = ()
    obstacle_speed_mps_max: float | None = None

    def __post_init__(self) -> None:
        checks.within(checks.said(self.bounds), self.fleet, (), None)
        checks.tracks(self.moving, None)

    @property
    def at_m(self) -> tuple[float, float] | None:
        """Rule 2."""
        start = self.fleet.places[0] if self.fleet.places else self.fleet.start
        if start is not None:
            return start[:2]
        return None if self.goal is None else self.goal.at_m

    def places(self, seed: int) -> tuple[Pose, ...]:
        """One place per robot, or all places that were found."""
        radius_m, bounds = self.fleet.robot_radius_m, checks.said(self.bounds)
        ground, clear_m = ground_of(self.obstacles), radius_m + self.law.epsilon_m
        speed_mps = top_speed_mps(self.moving, self.obstacle_speed_mps_max)
        return free_places(
            self.fleet.robots,
            piece_of(ground, bounds, at_m=self.at_m, hull_m=radius_m, clear_m=clear_m),
            Movers.of(self.moving).among(ground, 0.0),
            # The tolerance covers what bodies drift from their courses.
            inside=bounds.inset(radius_m + self.law.mu0_m),
            seed=seed,
            clear_m=clear_m,
            # The distance that a joining robot keeps from all others.
            apart_m=robot_keep_m(
                robot_radius_m=radius_m,
                separation_m=self.fleet.separation_m,
                mu0_m=self.law.mu0_m,
                obstacle_speed_mps_max=speed_mps if self.law.promises_clearance else 0.0,
            ),
        )


def is_undeployed(raw: dict[str, Any]) -> bool:
    """Whether the scenario asks for random places that are not drawn yet."""
    fleet = raw.get("fleet")
    return isinstance(fleet, dict) and "deployment" in fleet and "places" not in fleet


def deployed(raw: dict[str, Any], *, seed: int, source: str) -> dict[str, Any]:
    """The scenario with its fleet at random places; `source` names it in error messages.

    Raises:
        UsageError: it has no bounds, no room for so many robots, or is invalid.
    """
    site = understand(raw, _Site, source)
    places = site.places(seed)
    if len(places) < site.fleet.robots:
        rule = f"<= {len(places)}, for which seed {seed} finds free places"
        raise UsageError(f"{source}: $.fleet.robots: must be {rule}, got {site.fleet.robots}")
    fleet = {name: value for name, value in raw["fleet"].items() if name not in SAID}
    fleet["places"] = [(place.x_m, place.y_m, place.heading_rad) for place in places]
    return {**raw, "fleet": fleet}


def free_places(
    robots: int,
    piece: Piece,
    ground: Ground,
    *,
    inside: Bounds,
    seed: int,
    clear_m: float,
    apart_m: float,
) -> tuple[Pose, ...]:
    """Places where robots can start: fewer than requested if there is no room for more.

    Args:
        robots: number of places to draw.
        piece: the ground where a robot can stand.
        ground: the obstacles; moving ones at their first places.
        inside: the rectangle for centres.
        seed: the run's seed; with more robots, the first ones get the same places.
        clear_m: least distance of a centre from an obstacle.
        apart_m: least distance between two centres.
    """
    chance = stream(seed, "deployment")
    high_m = piece.low_m + piece.cell_m * np.array(piece.cells.shape)
    poses: list[Pose] = []
    for _ in range(robots):
        for _ in range(TRIES):
            x_m, y_m = chance.uniform(piece.low_m, high_m).tolist()
            heading_rad = float(chance.uniform(-np.pi, np.pi))
            apart = all(math.hypot(x_m - pose.x_m, y_m - pose.y_m) >= apart_m for pose in poses)
            held = piece.holds(x_m, y_m) and _is_in(inside, x_m, y_m)
            if apart and held and _clear_m(ground, x_m, y_m) >= clear_m:
                poses.append(Pose(x_m=x_m, y_m=y_m, heading_rad=heading_rad))
                break
        else:
            break
    return tuple(poses)


def _is_in(bounds: Bounds, x_m: float, y_m: float) -> bool:
    return bounds.x_m_min <= x_m <= bounds.x_m_max and bounds.y_m_min <= y_m <= bounds.y_m_max


def _clear_m(ground: Ground, x_m: float, y_m: float) -> float:
    return float(distances(ground, np.array((x_m, y_m))).min(initial=math.inf))
