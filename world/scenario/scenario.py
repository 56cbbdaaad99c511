"""A scenario: the complete description of a run, read from TOML or a `clew-scene/1` file, and checked.

Rule 1: every scenario object is valid; its construction refuses invalid relations.
Rule 2: the timeline's header contains the whole scenario; read from there it is equal.
"""

import math
from functools import cached_property
from hashlib import blake2b
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct, field

from protocol.errors import UsageError
from protocol.files.reading import understand
from protocol.files.refusals import short
from protocol.frames import Length, Point, Speed
from protocol.mission import RAYS_MAX, Bounds, Mission
from world.geometry.movers import Movers
from world.geometry.moving import Moving, top_speed_mps
from world.geometry.shapes import Circle, Ground, Shape, ground_of
from world.scenario import checks, scene
from world.scenario.budget import NOISE_SIGMAS, Budget, budget, revolutions, sure_range_m
from world.scenario.corners import sharpest_corner_rad
from world.scenario.deployment import deployed, is_undeployed
from world.scenario.reading import name_law, read_found
from world.scenario.sections import DriveSection, Fleet, Goal, LawSection, SensorSection, Text, TimeSection

Positions = Annotated[int, Meta(ge=1, le=2**53)]  # 2**53: JSON readers keep integers exact up to here
Table = Annotated[
    tuple[tuple[Length, ...], ...],
    Meta(description="m, one row per switching position, one column per obstacle"),
]

OBSTACLES_MAX = 10_000
SURE_RANGE_KEEPS = 12.0
"""Out to so many least centre distances, scans must show every obstacle, by more revolutions if needed."""


class Scenario(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, dict=True):
    """The obstacles, the fleet, its sensor and drives, the law, and the goal."""

    name: Annotated[str, Meta(min_length=1, max_length=200, description="its name in verdicts")]
    description: Annotated[Text, Meta(description="free text for readers")] = ""
    fleet: Annotated[Fleet, Meta(description="the robots and where they start")]
    law: Annotated[LawSection, Meta(description="the law of the leader, and the clearance to keep")]
    sensor: Annotated[SensorSection, Meta(description="the range sensor that every body carries")]
    drive: Annotated[DriveSection, Meta(description="the speeds and errors of the bodies' drives")]
    time: Annotated[TimeSection, Meta(description="how long a run may take")]
    goal: Annotated[
        Goal | None, Meta(description="the goal; without it the leader takes the widest gap, step by step")
    ] = None
    bounds: Annotated[Bounds | None, Meta(description="the rectangle that no hull may leave")] = None
    obstacles: Annotated[
        tuple[Shape, ...],
        Meta(max_length=OBSTACLES_MAX, description="static obstacles; robots do not know them"),
    ] = field(default=(), name="obstacle")
    moving: Annotated[
        tuple[Moving, ...],
        Meta(max_length=1000, description="moving obstacles on tracks; robots know only their top speed"),
    ] = ()
    obstacle_speed_mps_max: Annotated[
        Speed | None,
        Meta(description="m/s, top speed of any obstacle; default: the fastest leg of any track"),
    ] = None
    switching_positions_max: Annotated[
        Positions | None,
        Meta(description="without a goal, the leader ends after this many switching positions"),
    ] = None
    table_m: Annotated[
        Table | None,
        Meta(description="m, reference distances from leader to obstacles: the paper's Table I"),
    ] = None

    def __post_init__(self) -> None:
        checks.speeds(self.drive)
        checks.fleet(self.fleet)
        checks.law(self.law)
        checks.table(self.table_m, len(self.obstacles), self.switching_positions_max)
        checks.tracks(self.moving, self.obstacle_speed_mps_max)
        checks.sight(self.sensor, self.rays, self.range_m_used, self.closest_m)
        if self.law.promises_clearance:
            checks.errors_covered(self.law, self.error_budget)
        poses, radius_m, mission = self.fleet.poses(), self.fleet.robot_radius_m, self.mission()
        checks.no_hull_is_anothers(self.fleet, mission)
        checks.legs(self.fleet, mission)
        checks.places_apart(self.fleet, poses, mission)
        checks.within(self.bounds, self.fleet, poses, self.goal)
        checks.room_for_path(self.bounds, mission)
        checks.near_path(self.fleet, poses, mission, self.error_budget)
        standoff_m = max(self.closest_m, mission.moves_off_m) if mission.promises_clearance else radius_m
        checks.clear_of(self.obstacles, self.ground, self.fleet, poses, self.goal, standoff_m=standoff_m)
        checks.untouched(self.movers, self.fleet, poses)

    @cached_property
    def ground(self) -> Ground:
        """The static obstacles, packed into arrays."""
        return ground_of(self.obstacles)

    @cached_property
    def movers(self) -> Movers:
        """The moving obstacles, packed into arrays."""
        return Movers.of(self.moving)

    @property
    def seen_shapes(self) -> tuple[Shape, ...]:
        """The shapes of all obstacles, static and moving."""
        return (*self.obstacles, *(each.outline for each in self.moving))

    @property
    def solid_shapes(self) -> tuple[Shape, ...]:
        """The same and a robot's hull: a robot that is left out is seen by scans alone."""
        radius_m = self.fleet.robot_radius_m
        is_seen = self.law.promises_clearance and self.fleet.robots > 1 and radius_m > 0.0
        hulls = (Circle(centre_m=(0.0, 0.0), radius_m=radius_m),) if is_seen else ()
        return (*self.seen_shapes, *hulls)

    @property
    def closest_m(self) -> float:
        """The least distance of a robot's centre from an obstacle: r + epsilon."""
        return self.fleet.robot_radius_m + self.law.epsilon_m

    @cached_property
    def revolutions(self) -> int:
        """Revolutions per scan; one under a law without promises, as in the paper."""
        if not self.law.promises_clearance:
            return 1
        return revolutions(
            self.solid_shapes,
            self.sensor.directions,
            wanted_m=min(self.sensor.range_m_max, SURE_RANGE_KEEPS * self.closest_m),
            rays_max=RAYS_MAX,
        )

    @property
    def rays(self) -> int:
        """The number of directions of a scan with all its revolutions."""
        return self.sensor.directions * self.revolutions

    @cached_property
    def range_m_used(self) -> float:
        """The range limit of the robots' scans: the sensor is sure to see all solid shapes within it."""
        return min(self.sensor.range_m_max, sure_range_m(self.solid_shapes, self.rays))

    @property
    def range_error_m_max(self) -> float:
        """The largest error of a range: errors are clipped there."""
        return NOISE_SIGMAS * self.sensor.range_sigma_m

    @cached_property
    def sharpest_corner_rad(self) -> float:
        """The least angle of any corner that a ray can meet, at most a right angle."""
        return sharpest_corner_rad(self.obstacles, [each.outline for each in self.moving])

    @property
    def error_budget(self) -> Budget:
        """The errors that mu0 has to cover under a law that promises clearance."""
        return budget(
            rays=self.rays,
            closest_m=self.closest_m,
            range_sigma_m=self.sensor.range_sigma_m,
            heading_error_rad=self.drive.heading_error_rad,
            range_m_max=self.range_m_used,
        )

    def mission(self) -> Mission:
        """The mission that every robot gets."""
        goal = self.goal
        return Mission(
            robots=self.fleet.robots,
            robot_radius_m=self.fleet.robot_radius_m,
            law=self.law.law,
            epsilon_m=self.law.epsilon_m,
            mu0_m=self.law.mu0_m,
            separation_m=self.fleet.separation_m,
            speed_mps=self.drive.speed_mps,
            directions=self.sensor.directions,
            revolutions=self.revolutions,
            range_m_max=self.range_m_used,
            range_error_m_max=self.range_error_m_max,
            sharpest_corner_rad=self.sharpest_corner_rad,
            link_length_m_max=self.fleet.link_length_m_max,
            goal=None if goal is None else Point(x_m=goal.at_m[0], y_m=goal.at_m[1]),
            goal_tolerance_m=0.0 if goal is None else goal.tolerance_m,
            bounds=self.bounds,
            switching_positions_max=self.switching_positions_max,
            obstacle_speed_mps_max=top_speed_mps(self.moving, self.obstacle_speed_mps_max),
        )

    @cached_property
    def obstacles_move(self) -> bool:
        """Whether robots take scans while they drive."""
        return self.mission().obstacles_move

    @cached_property
    def still_s(self) -> float:
        """From this time on no obstacle moves, so no way opens that was not there before."""
        return max((each.track[-1][0] for each in self.moving), default=-math.inf)

    def fingerprint(self) -> str:
        """A hash of the content: equal scenarios have equal hashes."""
        return blake2b(msgspec.json.encode(self, order="deterministic"), digest_size=16).hexdigest()


def load(
    name_or_path: str,
    *,
    robots: int | None = None,
    law: str | None = None,
    deployment: str | None = None,
    time_s_max: float | None = None,
    seed: int = 1,
) -> Scenario:
    """Load the scenario with that name in launch/scenarios, or from that .toml or clew-scene/1 .json file.

    Args:
        name_or_path: the name or the path.
        robots: overrides the scenario's number of robots.
        law: overrides the scenario's law.
        deployment: overrides the scenario's places.
        time_s_max: overrides the scenario's time limit.
        seed: the run's seed; it decides a random deployment.

    Raises:
        UsageError: the scenario is invalid; one line says why.
    """
    path, said = read_found(name_or_path)
    raw = scene.as_scenario(said, name_or_path) if path.suffix == ".json" else said
    if isinstance(raw.get("fleet"), list):
        raise UsageError(
            f"{name_or_path}: has several fleets; only the commands `clew run` and `clew rehearse` take them"
        )
    changes = _override(
        raw,
        ("fleet", "robots", robots),
        ("law", "law", law),
        ("fleet", "deployment", deployment),
        ("time", "time_s_max", time_s_max),
    )
    try:
        if deployment is not None or is_undeployed(raw):
            raw = deployed(raw, seed=seed, source=name_or_path)
        name_law(raw, path.parent if law is None else Path(), name_or_path)
        return understand(raw, Scenario, name_or_path)
    except UsageError as error:
        line = scene.in_own_words(str(error), said) if path.suffix == ".json" else str(error)
        raise UsageError(f"{line} ({', '.join(changes)})" if changes else line) from error


def _override(raw: dict[str, Any], *asked: tuple[str, str, str | float | None]) -> list[str]:
    """Put what was asked for (section, field, value) into a scenario; returns the changes as text."""
    changes = []
    for section, key, value in asked:
        if value is not None and isinstance(raw.get(section), dict):
            instead = f" instead of {short(raw[section][key])}" if key in raw[section] else ""
            changes.append(f"{key} = {short(value)}{instead}")
            raw[section][key] = value
    return changes


def schema() -> dict[str, Any]:
    """The JSON Schema of scenario files, as kept in launch/scenarios for editors."""
    return msgspec.json.schema(Scenario)
