"""Several fleets on one ground: a scenario file whose `fleet` is a list, and the scenario of each fleet.

Rule 1: each fleet gets a scenario of its own, as if it were alone; its `obstacle_speed_mps_max` is at least
        the speed of the robots. So the other fleets' robots are moving obstacles to it.
Rule 2: the law certifies every step: without scans while driving no robot keeps off another fleet.
Rule 3: the sensor is sure to show every other hull within the range in use.
Rule 4: robots of two fleets start so far apart that each may move, whatever the other hides.
"""

from collections.abc import Iterator
from itertools import combinations
from math import dist
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta, Struct, ValidationError, convert, field, to_builtins

from protocol.arrays import Floats
from protocol.errors import UsageError
from protocol.files.reading import understand
from protocol.frames import FLEETS_MAX, ROBOTS_MAX, Speed
from protocol.mission import Bounds
from protocol.run_settings import SEED_MAX
from world.chance import stream
from world.geometry.moving import Moving, top_speed_mps
from world.geometry.shapes import Circle, Shape
from world.scenario.budget import sure_range_m
from world.scenario.reading import name_law, read_found
from world.scenario.scenario import OBSTACLES_MAX, Scenario, load
from world.scenario.sections import DriveSection, Fleet, Goal, LawSection, SensorSection, Text, TimeSection

FLEET_NAME = r"[a-z][a-z0-9-]*"
FleetName = Annotated[
    str,
    Meta(
        pattern=f"^{FLEET_NAME}$",
        max_length=32,
        extra={"words": "at most 32 small letters, digits and '-', a letter first"},
    ),
]
ROUNDING_M = 1e-9


class NamedFleet(Fleet, frozen=True, kw_only=True):
    """One of several fleets: as `[fleet]`, with a name and a goal of its own."""

    name: Annotated[FleetName, Meta(description="its name, and that of its folder in the run's")]
    goal: Annotated[Goal, Meta(description="the goal of its leader")]


class SharedGround(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A scenario with several fleets; every other field is that of a scenario, and counts for all of them."""

    name: Annotated[str, Meta(min_length=1, max_length=200)]
    description: Text = ""
    fleets: Annotated[tuple[NamedFleet, ...], Meta(min_length=2, max_length=FLEETS_MAX)] = field(name="fleet")
    law: LawSection
    sensor: SensorSection
    drive: DriveSection
    time: TimeSection
    bounds: Bounds | None = None
    obstacles: Annotated[tuple[Shape, ...], Meta(max_length=OBSTACLES_MAX)] = field(
        default=(), name="obstacle"
    )
    moving: Annotated[tuple[Moving, ...], Meta(max_length=1000)] = ()
    obstacle_speed_mps_max: Speed | None = None

    def __post_init__(self) -> None:
        for refusal in self._refusals():
            raise ValueError(refusal)

    def _refusals(self) -> Iterator[str]:
        names = [each.name for each in self.fleets]
        for row, name in enumerate(names):
            if name in names[:row]:
                yield f"$.fleet[{row}].name: must be another than those before it, got {name!r}"
        robots = sum(each.robots for each in self.fleets)
        if robots > ROBOTS_MAX:
            yield f"$.fleet: must have at most {ROBOTS_MAX} robots together, got {robots}"
        if not self.law.promises_clearance:
            yield f"$.law.law: must be one that certifies steps beside other fleets, got {self.law.law!r}"
        for (one, first), (other, second) in combinations(enumerate(self.fleets), 2):
            yield from self._too_near(one, first, other, second)

    def _too_near(self, one: int, first: NamedFleet, other: int, second: NamedFleet) -> Iterator[str]:
        """Robots of two fleets start as far apart as obstacles are passed; so are the goals."""
        least_m = first.robot_radius_m + second.robot_radius_m + self.law.epsilon_m
        if _unplaced(first) or _unplaced(second):
            return  # the scenario of that fleet is refused
        for robot, here in enumerate(second.poses(), start=1):
            for there in first.poses():
                apart_m = dist((here.x_m, here.y_m), (there.x_m, there.y_m))
                if apart_m < least_m - ROUNDING_M:
                    yield (
                        f"$.fleet[{other}]: robot {robot} must start >= {least_m:g} m from every robot of "
                        f"fleet[{one}], got {apart_m:.6g} m"
                    )
        apart_m = dist(first.goal.at_m, second.goal.at_m)
        if apart_m < least_m - ROUNDING_M:
            yield f"$.fleet[{other}].goal: must be >= {least_m:g} m from fleet[{one}]'s, got {apart_m:.6g} m"

    @property
    def speed_mps_max(self) -> float:
        """What every fleet has to expect of anything that moves (rule 1)."""
        return max(self.drive.speed_mps, top_speed_mps(self.moving, self.obstacle_speed_mps_max))

    def scenarios(self) -> dict[str, Scenario]:
        """The scenario of each fleet, by name, in the file's order.

        Raises:
            ValueError: it is invalid; the message begins with the path.
        """
        shared = to_builtins(self)
        del shared["fleet"]
        made = {}
        for row, each in enumerate(self.fleets):
            own = to_builtins(each)
            goal, name = own.pop("goal"), own.pop("name")
            raw = shared | {
                "name": f"{self.name}: {name}",
                "fleet": own,
                "goal": goal,
                "obstacle_speed_mps_max": self.speed_mps_max,
            }
            try:
                scenario = convert(raw, Scenario)
            except ValidationError as error:
                raise ValueError(f"{error} (fleet[{row}], {name})") from error
            self._check_sight(row, each, scenario)
            self._check_starts(row, scenario)
            made[name] = scenario
        return made

    def _check_sight(self, row: int, fleet: NamedFleet, scenario: Scenario) -> None:
        """Rule 3."""
        others = [each.robot_radius_m for each in self.fleets if each is not fleet]
        radius_m = min(others)
        thin = [Circle(centre_m=(0.0, 0.0), radius_m=radius_m)] if radius_m > 0.0 else []
        sure_m = sure_range_m(thin, scenario.rays) if thin else 0.0
        if sure_m < scenario.range_m_used:
            raise ValueError(
                f"$.sensor: must be sure of hulls with a radius of {radius_m:g} m out to its range, "
                f"{scenario.range_m_used:g} m, got {sure_m:.6g} m with {scenario.rays} directions "
                f"(fleet[{row}], {fleet.name})"
            )

    def _check_starts(self, row: int, scenario: Scenario) -> None:
        """Rule 4."""
        here_m = _places_m(self.fleets[row])
        for other, each in enumerate(self.fleets):
            if other == row or _unplaced(each):
                continue
            least_m = scenario.mission().moves_off_m + each.robot_radius_m
            apart_m = np.hypot(*(here_m[:, None] - _places_m(each)).T).min(axis=0)
            robot = int(apart_m.argmin())
            if apart_m[robot] < least_m - ROUNDING_M:
                raise ValueError(
                    f"$.fleet[{row}]: robot {robot + 1} must start >= {least_m:.4g} m from every robot of "
                    f"fleet[{other}], got {apart_m[robot]:.6g} m: nearer to one that may hide another robot, "
                    f"it cannot move"
                )


def seed_of(seed: int, fleet: str) -> int:
    """The seed of one fleet: with one seed for all, robots of the same number would draw the same errors."""
    return int(stream(seed, f"fleet/{fleet}").integers(SEED_MAX))


def _places_m(fleet: Fleet) -> Floats:
    return np.array([(pose.x_m, pose.y_m) for pose in fleet.poses()])


def _unplaced(fleet: Fleet) -> bool:
    return fleet.places is None and (fleet.start is None or fleet.spacing_m is None)


def has_several(name_or_path: str) -> bool:
    """Whether a scenario file has several fleets.

    Raises:
        UsageError: it cannot be read.
    """
    path, said = read_found(name_or_path)
    return path.suffix != ".json" and isinstance(said.get("fleet"), list)


def load_fleets(
    name_or_path: str,
    *,
    robots: int | None = None,
    law: str | None = None,
    time_s_max: float | None = None,
) -> SharedGround:
    """Load a scenario with several fleets.

    Args:
        name_or_path: as `scenario.load` takes it.
        robots: overrides the number of robots of each fleet.
        law: overrides the law of all.
        time_s_max: overrides the time limit.

    Raises:
        UsageError: it is invalid; one line says why.
    """
    path, raw = read_found(name_or_path)
    for section, key, value in (("law", "law", law), ("time", "time_s_max", time_s_max)):
        _put(raw.get(section), key, value)
    for each in raw.get("fleet", ()):
        _put(each, "robots", robots)
    name_law(raw, path.parent if law is None else Path(), name_or_path)
    shared = understand(raw, SharedGround, name_or_path)
    try:
        shared.scenarios()
    except ValueError as error:
        raise UsageError(f"{name_or_path}: {error}") from error
    return shared


def load_any(
    name_or_path: str,
    *,
    robots: int | None,
    law: str | None,
    deployment: str | None,
    time_s_max: float | None,
    seed: int,
) -> Scenario | SharedGround:
    """Load a scenario with one fleet, as `scenario.load` does, or with several.

    Raises:
        UsageError: it is invalid, or several fleets are to start at random places.
    """
    if not has_several(name_or_path):
        return load(
            name_or_path, robots=robots, law=law, deployment=deployment, time_s_max=time_s_max, seed=seed
        )
    if deployment is not None:
        raise UsageError("--deployment: is for a scenario with one fleet")
    return load_fleets(name_or_path, robots=robots, law=law, time_s_max=time_s_max)


def _put(section: Any, key: str, value: object) -> None:  # noqa: ANN401 - a part of a file, unchecked
    if value is not None and isinstance(section, dict):
        section[key] = value
