"""The field generator: random obstacle worlds, each determined by its kind, its seed and a few numbers.

Rule 1: a field is a pure function of its parameters, the same on any machine: draws come from one stream for
        each kind and seed, and coordinates are rounded.
Rule 2: obstacles keep the least width from each other and from the walls, so anything thinner gets through;
        what is built instead of scattered has ways of exactly that width. A field promises nothing else.
Rule 3: no obstacle is in the lanes before and behind the field, where the fleet starts and ends. Only round
        fields have the goal in their middle.
"""

from collections.abc import Callable
from typing import Annotated, Any

from msgspec import Meta, Struct
from numpy.random import Generator

from clew.fields.built import Built, cells_of, rectangle
from clew.fields.gates import pillars, rooms
from clew.fields.kinds import DENSITY, ROBOT_RADIUS_M, SIZE_M, WIDTH_RADII, Kind
from clew.fields.lanes import comb, zigzag
from clew.fields.maze import maze
from clew.fields.round import rings, spiral
from clew.fields.scatter import scatter
from clew.fields.shapes import DECIMALS, DRAWS, area_m2
from protocol.errors import UsageError
from protocol.run_settings import SEED_MAX
from world.chance import stream
from world.geometry.shapes import Circle, Polygon
from world.scenario.scenario import OBSTACLES_MAX
from world.scenario.scene import EPSILON_M_MAX, EPSILON_RADII

ROBOTS = 5  # the lanes have room for so many
SPACING_RADII = 3.0  # the rule of clew-scene/1 for the places of robots
LANE_RADII = SPACING_RADII * (ROBOTS + 1)  # their places, and room before the first and behind the last
WALL_RADII = 1.0  # a scan with rays one degree apart certainly hits it up to 57 radii away
CELLS_MIN = 2  # columns and rows of a maze
SIDE_CELLS_MIN = 6  # least side of other built ground, in corridors: two rooms, two rings, a leg that climbs
SIDE_M_MAX = 1000.0  # a larger field has more obstacles than a scenario may have

Side = Annotated[float, Meta(ge=0.01, le=SIDE_M_MAX)]


BUILDERS: dict[Kind, Callable[..., Built]] = {
    Kind.ZIGZAG: zigzag,
    Kind.COMB: comb,
    Kind.SPIRAL: spiral,
    Kind.RINGS: rings,
    Kind.ROOMS: rooms,
    Kind.PILLARS: pillars,
}
"""What builds ground; a maze of corridors takes a number of cells instead of a size."""
BUILT = frozenset({Kind.CORRIDORS, *BUILDERS})


class Field(Struct, frozen=True, kw_only=True):
    """The parameters of a field."""

    kind: Kind
    seed: Annotated[int, Meta(ge=0, le=SEED_MAX)]
    robot_radius_m: Annotated[float, Meta(ge=0.01, le=SIDE_M_MAX)] = ROBOT_RADIUS_M
    density: Annotated[float, Meta(ge=0.0, le=1.0)] = DENSITY
    """Share of the ground that obstacles cover, approximately; built ground ignores it."""
    least_width_m: Annotated[float, Meta(ge=0.0, le=SIDE_M_MAX)] | None = None
    """Least gap between obstacles (0: they may overlap), or width of built ways; default: four radii."""
    spare: Annotated[float, Meta(ge=0.0, le=10.0)] | None = None
    """Instead of `least_width_m`: how much wider than `2 (r + epsilon)`, as a share."""
    size_m: tuple[Side, Side] = SIZE_M
    """Size of the ground without the lanes; built ground fills as much of it as it can."""
    plugged: bool = False
    """Whether the only way through the corridors is closed."""

    def __post_init__(self) -> None:
        corridors, wide_m = self.kind is Kind.CORRIDORS, self.width_m + self.wall_m
        if self.spare is not None and self.least_width_m is not None:
            raise ValueError("$.spare: replaces least_width_m, so one of them must not be given")
        if self.plugged and not corridors:
            raise ValueError(f"$.plugged: is for {Kind.CORRIDORS} only, got {self.kind}")
        if self.kind in BUILT and self.width_m < self.robot_radius_m:
            raise ValueError(
                f"$.least_width_m: must be >= robot_radius_m = {self.robot_radius_m:g} m for {self.kind},"
                f" got {self.width_m:g}"
            )
        if corridors and min(self.cells) < CELLS_MIN:
            raise ValueError(
                f"$.size_m: must hold {CELLS_MIN} x {CELLS_MIN} corridors of {self.width_m:g} m"
                f" between walls of {self.wall_m:g} m, got {self.size_m[0]:g} x {self.size_m[1]:g}"
            )
        if self.kind in BUILDERS and min(self.size_m) < SIDE_CELLS_MIN * wide_m:
            raise ValueError(
                f"$.size_m: must be >= {SIDE_CELLS_MIN * wide_m:g} m, {SIDE_CELLS_MIN} times a way and a"
                f" wall, for {self.kind}, got {self.size_m[0]:g} x {self.size_m[1]:g}"
            )

    @property
    def width_m(self) -> float:
        """The least width, given or by default."""
        if self.spare is not None:
            epsilon_m = min(EPSILON_M_MAX, EPSILON_RADII * self.robot_radius_m)
            return 2.0 * (self.robot_radius_m + epsilon_m) * (1.0 + self.spare)
        return WIDTH_RADII * self.robot_radius_m if self.least_width_m is None else self.least_width_m

    @property
    def wall_m(self) -> float:
        """Thickness of walls."""
        return WALL_RADII * self.robot_radius_m

    @property
    def cells(self) -> tuple[int, int]:
        """Columns and rows of corridors."""
        return cells_of(self.size_m, self.width_m, self.wall_m)


def scene(field: Field) -> dict[str, Any]:
    """The field as a `clew-scene/1` [m; world frame]; the fleet starts on its left.

    Raises:
        UsageError: it has more obstacles than a scenario may have.
    """
    made = _built(field) if field.kind in BUILT else _scattered(field)
    if sum(len(made[each]) for each in ("circles", "polygons", "walls")) > OBSTACLES_MAX:
        width_m, height_m = field.size_m
        raise UsageError(
            f"clew field: $.size_m: {field.kind} of {width_m:g} x {height_m:g} m have more than"
            f" {OBSTACLES_MAX} obstacles, and a scenario may not; make the ground smaller, or less dense"
        )
    return made


def mark(kind: str, seed: int) -> bytes:
    """What stands near the beginning of the file of such a field."""
    return f'"name": "{kind}-{seed}", "family": "{kind}", "units": "m"'.encode()


def _built(field: Field) -> dict[str, Any]:
    built = _build(field)
    size_m = (round(built.size_m[0], DECIMALS), round(built.size_m[1], DECIMALS))
    entrance_y_m, exit_y_m = round(built.entrance_y_m, DECIMALS), round(built.exit_y_m, DECIMALS)
    drawn = _lanes(field, size_m, start_y_m=entrance_y_m, goal_y_m=exit_y_m) | {
        "circles": built.pillars,
        "polygons": built.walls,
        "stats": {"widest_path_radius": 0.0 if field.plugged else field.width_m / 2.0},
    }
    if built.goal_m is not None:  # so near to it that no wall is between
        drawn |= {"goal": built.goal_m, "goal_tol": field.robot_radius_m}
    return drawn


def _build(field: Field) -> Built:
    chance, width_m, wall_m = _chance(field), field.width_m, field.wall_m
    if field.kind is Kind.CORRIDORS:
        return maze(*field.cells, chance, width_m=width_m, wall_m=wall_m, plugged=field.plugged)
    return BUILDERS[field.kind](chance, size_m=field.size_m, width_m=width_m, wall_m=wall_m)


def _scattered(field: Field) -> dict[str, Any]:
    obstacles = scatter(
        DRAWS[field.kind],
        _chance(field),
        size_m=field.size_m,
        density=field.density,
        least_width_m=field.width_m,
        unit_m=field.robot_radius_m,
    )
    width_m, height_m = field.size_m
    covered_m2 = sum(area_m2(obstacle) for obstacle in obstacles)
    return _lanes(field, field.size_m, start_y_m=height_m / 2.0, goal_y_m=height_m / 2.0) | {
        "circles": [(*each.centre_m, each.radius_m) for each in obstacles if isinstance(each, Circle)],
        "polygons": [each.vertices_m for each in obstacles if isinstance(each, Polygon)],
        "stats": {"density": round(covered_m2 / (width_m * height_m), DECIMALS)},
    }


def _chance(field: Field) -> Generator:
    return stream(field.seed, f"field/{field.kind}")


def _lanes(field: Field, size_m: tuple[float, float], *, start_y_m: float, goal_y_m: float) -> dict[str, Any]:
    """A scene without obstacles, with lanes, and walls along both sides."""
    first_m, lane_m = SPACING_RADII * field.robot_radius_m, LANE_RADII * field.robot_radius_m
    low_m, high_m = round(-lane_m, DECIMALS), round(size_m[0] + lane_m, DECIMALS)
    return {
        "schema": "clew-scene/1",
        "name": f"{field.kind}-{field.seed}",
        "family": field.kind.value,
        "units": "m",
        "robot_radius": field.robot_radius_m,
        "start": (round(-first_m, DECIMALS), start_y_m, 0.0),
        "goal": (round(size_m[0] + first_m, DECIMALS), goal_y_m),
        "goal_tol": first_m,
        "bounds": (low_m, 0.0, high_m, size_m[1]),
        "circles": [],
        "polygons": [],
        "walls": [
            rectangle(low_m, high_m, -field.wall_m, 0.0),
            rectangle(low_m, high_m, size_m[1], size_m[1] + field.wall_m),
        ],
    }
