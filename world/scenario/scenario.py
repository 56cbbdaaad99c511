"""A scenario: all that a run is made of, read from TOML or from a `clew-scene/1` file, and checked.

Rule 1: a scenario that exists is sound; its construction refuses bad relations.
Rule 2: a scenario goes whole into the timeline's header and comes back the same.
"""

from functools import cached_property
from hashlib import blake2b
from typing import Annotated, Any

import msgspec
from msgspec import Meta, Struct, field

from protocol.errors import UsageError
from protocol.files.reading import read, understand
from protocol.frames import Length, Point, Speed
from protocol.mission import Bounds, Mission
from protocol.wire.messages import RAYS_MAX
from world.geometry.movers import Movers
from world.geometry.moving import Moving
from world.geometry.shapes import Ground, Shape, ground_of
from world.scenario import checks, scene
from world.scenario.budget import NOISE_SIGMAS, Budget, blind_per_range, budget, revolutions, sure_range_m
from world.scenario.deployment import deployed, is_undeployed
from world.scenario.reading import find
from world.scenario.sections import DriveSection, Fleet, Goal, LawSection, SensorSection, Text, TimeSection

Positions = Annotated[int, Meta(ge=1, le=2**53)]  # 2**53: what JSON readers keep exact
Table = Annotated[
    tuple[tuple[Length, ...], ...],
    Meta(description="m, a row for each switching position, a column for each obstacle"),
]


SURE_BERTHS = 12.0
"""Where one revolution may miss thin obstacles so near, in least distances of a centre, more are taken."""


class Scenario(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, dict=True):
    """The ground, the fleet, its senses and drives, the law, and what counts as done."""

    name: Annotated[str, Meta(min_length=1, max_length=200, description="what verdicts call it")]
    description: Annotated[Text, Meta(description="for people")] = ""
    fleet: Annotated[Fleet, Meta(description="the robots and where they start")]
    law: Annotated[LawSection, Meta(description="the law of the leader, and the clearance to keep")]
    sensor: Annotated[SensorSection, Meta(description="the range sensor that every body carries")]
    drive: Annotated[DriveSection, Meta(description="how bodies drive, and how well")]
    time: Annotated[TimeSection, Meta(description="how long a run may take")]
    goal: Annotated[
        Goal | None, Meta(description="where to; without it the leader takes the widest gap, step by step")
    ] = None
    bounds: Annotated[Bounds | None, Meta(description="the rectangle that no hull may leave")] = None
    obstacles: Annotated[
        tuple[Shape, ...],
        Meta(max_length=10_000, description="what stands in the way; robots are told nothing of it"),
    ] = field(default=(), name="obstacle")
    moving: Annotated[
        tuple[Moving, ...],
        Meta(max_length=1000, description="obstacles on tracks; robots are told of their top speed alone"),
    ] = ()
    obstacle_speed_mps_max: Annotated[
        Speed | None,
        Meta(description="m/s, no obstacle moves faster; if not said, the fastest leg of any track"),
    ] = None
    switching_positions_max: Annotated[
        Positions | None,
        Meta(description="without a goal, the leader is there when it has stopped at so many positions"),
    ] = None
    table_m: Annotated[
        Table | None,
        Meta(description="m, the leader's distances to the obstacles to compare with: the paper's Table I"),
    ] = None

    def __post_init__(self) -> None:
        checks.speeds(self.drive)
        checks.fleet(self.fleet)
        checks.law(self.law)
        checks.table(self.table_m, len(self.obstacles), self.switching_positions_max)
        checks.tracks(self.moving, self.obstacle_speed_mps_max)
        checks.sight(self.sensor, self.rays, self.range_m_used, self.closest_m)
        if self.law.law.promises_clearance:
            checks.errors_covered(self.law, self.error_budget)
        poses, radius_m = self.fleet.poses(), self.fleet.robot_radius_m
        checks.places_apart(self.fleet, poses)
        checks.within(self.bounds, self.fleet, poses, self.goal)
        standoff_m = self.closest_m if self.law.law.promises_clearance else radius_m
        checks.clear_of(self.ground, self.fleet, poses, self.goal, standoff_m)
        checks.untouched(self.movers, self.fleet, poses)

    @cached_property
    def ground(self) -> Ground:
        """The obstacles that never move, packed into arrays."""
        return ground_of(self.obstacles)

    @cached_property
    def movers(self) -> Movers:
        """The moving obstacles, packed likewise."""
        return Movers.of(self.moving)

    @property
    def seen_shapes(self) -> tuple[Shape, ...]:
        """What the sensor has to be sure of, wherever it is: obstacles that stand and that move."""
        return (*self.obstacles, *(each.outline for each in self.moving))

    @property
    def closest_m(self) -> float:
        """How near a robot's centre may come to an obstacle: r + epsilon."""
        return self.fleet.robot_radius_m + self.law.epsilon_m

    @cached_property
    def revolutions(self) -> int:
        """How many of the scanner make a scan; under a law that promises nothing one, as in the paper."""
        if not self.law.law.promises_clearance:
            return 1
        return revolutions(
            self.seen_shapes,
            self.sensor.directions,
            wanted_m=min(self.sensor.range_m_max, SURE_BERTHS * self.closest_m),
            rays_max=RAYS_MAX,
        )

    @property
    def rays(self) -> int:
        """Directions of a scan, of all its revolutions."""
        return self.sensor.directions * self.revolutions

    @cached_property
    def range_m_used(self) -> float:
        """The range of the scans that robots get: as far as the sensor is sure to see every obstacle."""
        return min(self.sensor.range_m_max, sure_range_m(self.seen_shapes, self.rays))

    @property
    def range_error_m_max(self) -> float:
        """Where the sensor's error is clipped."""
        return NOISE_SIGMAS * self.sensor.range_sigma_m

    @cached_property
    def blind_per_range(self) -> float:
        """How far an obstacle may reach unseen past a ray that hit it, per metre of range."""
        return blind_per_range(self.seen_shapes, self.rays)

    @property
    def error_budget(self) -> Budget:
        """What mu0 has to cover under a law that promises clearance."""
        return budget(
            rays=self.rays,
            closest_m=self.closest_m,
            range_sigma_m=self.sensor.range_sigma_m,
            heading_error_rad=self.drive.heading_error_rad,
            range_m_max=self.range_m_used,
        )

    def mission(self) -> Mission:
        """What every robot is told."""
        goal, speed_mps_max = self.goal, self.obstacle_speed_mps_max
        if speed_mps_max is None:
            speed_mps_max = max((each.speed_mps_max for each in self.moving), default=0.0)
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
            blind_per_range=self.blind_per_range,
            link_length_m_max=self.fleet.link_length_m_max,
            goal=None if goal is None else Point(x_m=goal.at_m[0], y_m=goal.at_m[1]),
            goal_tolerance_m=0.0 if goal is None else goal.tolerance_m,
            bounds=self.bounds,
            switching_positions_max=self.switching_positions_max,
            obstacle_speed_mps_max=speed_mps_max,
        )

    def fingerprint(self) -> str:
        """A hash that two scenarios share exactly when they say the same."""
        return blake2b(msgspec.json.encode(self, order="deterministic"), digest_size=16).hexdigest()


def load(
    name_or_path: str,
    *,
    robots: int | None = None,
    law: str | None = None,
    deployment: str | None = None,
    seed: int = 1,
) -> Scenario:
    """The scenario of that name in launch/scenarios, or in that .toml or clew-scene/1 .json file.

    Args:
        name_or_path: which one.
        robots: overrides the scenario's number of robots.
        law: overrides the scenario's law.
        deployment: overrides where its robots start.
        seed: the run's; it decides a random deployment.

    Raises:
        UsageError: whatever is wrong, in one line.
    """
    path = find(name_or_path)
    said = read(path, name_or_path)
    raw = scene.as_scenario(said, name_or_path) if path.suffix == ".json" else said
    changes = _override(
        raw,
        ("-n", "fleet", "robots", robots),
        ("--law", "law", "law", law),
        ("--deployment", "fleet", "deployment", deployment),
    )
    try:
        if deployment is not None or is_undeployed(raw):
            raw = deployed(raw, seed=seed, source=name_or_path)
        return understand(raw, Scenario, name_or_path)
    except UsageError as error:
        line = scene.in_own_words(str(error), said) if path.suffix == ".json" else str(error)
        raise UsageError(f"{line} ({', '.join(changes)})" if changes else line) from error


def _override(raw: dict[str, Any], *options: tuple[str, str, str, str | int | None]) -> list[str]:
    """Put in what the command line says: option, section, field, value; returns what that changed."""
    changes = []
    for option, section, key, value in options:
        if value is not None and isinstance(raw.get(section), dict):
            instead = f" instead of its {key} = {raw[section][key]}" if key in raw[section] else ""
            changes.append(f"{option} {value}{instead}")
            raw[section][key] = value
    return changes


def schema() -> dict[str, Any]:
    """The JSON Schema of scenario files, as kept in launch/scenarios for editors."""
    return msgspec.json.schema(Scenario)
