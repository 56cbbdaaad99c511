"""The field generator: random obstacle worlds, each determined by its kind, its seed and a few numbers.

Rule 1: a field is a pure function of its parameters, the same on any machine: draws come from one stream for
        each kind and seed, and coordinates are rounded.
Rule 2: obstacles keep the least width from each other and from the walls, so anything thinner gets through;
        corridors are exactly that wide. A field promises nothing else.
Rule 3: no obstacle is in the lanes before and behind the field, where the fleet starts and ends.
"""

from enum import StrEnum
from typing import Annotated, Any

from msgspec import Meta, Struct
from numpy.random import Generator

from clew.fields.maze import maze, rectangle
from clew.fields.scatter import scatter
from clew.fields.shapes import DECIMALS, DRAWS, area_m2
from protocol.run_settings import SEED_MAX
from world.chance import stream
from world.geometry.shapes import Circle, Polygon

ROBOTS = 5  # the lanes have room for so many
SPACING_RADII = 3.0  # the rule of clew-scene/1 for the places of robots
LANE_RADII = SPACING_RADII * (ROBOTS + 1)  # their places, and room before the first and behind the last
WIDTH_RADII = 4.0  # r + epsilon is at most 1.5 r, so this is a third more than the fleet needs
WALL_RADII = 1.0  # a scan with rays one degree apart certainly hits it up to 57 radii away
CELLS_MIN = 2  # columns and rows of a maze
ROBOT_RADIUS_M = 0.15  # as in most scenes from public data
DENSITY = 0.06  # fits for every kind at the default width
SIZE_M = (10.0, 6.0)  # a room
SIDE_M_MAX = 1000.0  # a larger field has more obstacles than a scenario may have

Side = Annotated[float, Meta(gt=0.0, le=SIDE_M_MAX)]


class Kind(StrEnum):
    """The obstacles of a field."""

    CIRCLES = "circles"
    ELLIPSES = "ellipses"
    CONVEX = "convex"
    NONCONVEX = "nonconvex"
    MIXED = "mixed"
    CORRIDORS = "corridors"


class Field(Struct, frozen=True, kw_only=True):
    """The parameters of a field."""

    kind: Kind
    seed: Annotated[int, Meta(ge=0, le=SEED_MAX)]
    robot_radius_m: Annotated[float, Meta(ge=0.01, le=SIDE_M_MAX)] = ROBOT_RADIUS_M
    density: Annotated[float, Meta(ge=0.0, le=1.0)] = DENSITY
    """Share of the ground that obstacles cover, approximately; corridors ignore it."""
    least_width_m: Annotated[float, Meta(ge=0.0, le=SIDE_M_MAX)] | None = None
    """Least gap between obstacles (0: they may overlap), or width of corridors; default: four radii."""
    size_m: tuple[Side, Side] = SIZE_M
    """Size of the ground without the lanes; corridors fill as much of it as whole cells can."""
    plugged: bool = False
    """Whether the only way through the corridors is closed."""

    def __post_init__(self) -> None:
        corridors = self.kind is Kind.CORRIDORS
        if self.plugged and not corridors:
            raise ValueError(f"$.plugged: is for {Kind.CORRIDORS} only, got {self.kind}")
        if corridors and self.width_m < self.robot_radius_m:
            raise ValueError(
                f"$.least_width_m: must be >= robot_radius_m = {self.robot_radius_m:g} m for {self.kind},"
                f" got {self.width_m:g}"
            )
        if corridors and min(self.cells) < CELLS_MIN:
            raise ValueError(
                f"$.size_m: must hold {CELLS_MIN} x {CELLS_MIN} corridors of {self.width_m:g} m"
                f" between walls of {self.wall_m:g} m, got {self.size_m[0]:g} x {self.size_m[1]:g}"
            )

    @property
    def width_m(self) -> float:
        """The least width, given or by default."""
        return WIDTH_RADII * self.robot_radius_m if self.least_width_m is None else self.least_width_m

    @property
    def wall_m(self) -> float:
        """Thickness of walls."""
        return WALL_RADII * self.robot_radius_m

    @property
    def cells(self) -> tuple[int, int]:
        """Columns and rows of corridors; the walls along the long sides are outside the ground."""
        pitch_m = self.width_m + self.wall_m
        return int((self.size_m[0] - self.wall_m) / pitch_m), int((self.size_m[1] + self.wall_m) / pitch_m)


def scene(field: Field) -> dict[str, Any]:
    """The field as a `clew-scene/1` [m; world frame]: start on the left, goal on the right."""
    return _corridors(field) if field.kind is Kind.CORRIDORS else _scattered(field)


def _corridors(field: Field) -> dict[str, Any]:
    built = maze(
        *field.cells,
        _chance(field),
        width_m=field.width_m,
        wall_m=field.wall_m,
        plugged=field.plugged,
    )
    empty = _lanes(field, built.size_m, start_y_m=built.entrance_y_m, goal_y_m=built.exit_y_m)
    return empty | {
        "polygons": built.walls,
        "stats": {"widest_path_radius": 0.0 if field.plugged else field.width_m / 2.0},
    }


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
