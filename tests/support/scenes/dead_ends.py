"""Scenes with dead ends: free ground surrounded by walls. Not a test file."""

from collections.abc import Sequence

import shapely

from tests.support.scenes.placed import placed, polygon
from world.scenario.scenario import Scenario

RADIUS_M = 0.1
EPSILON_M = 0.1
HALF_WIDTH_M = 0.3  # of a corridor: two robots side by side would need 0.33 m
WALL_M = 0.15
SPACING_M = 0.3

Corner = tuple[float, float]


def corridors(*lines: Sequence[Corner], half_width_m: float = HALF_WIDTH_M) -> shapely.Geometry:
    """The ground within this distance of the lines, with square corners and ends."""
    return shapely.union_all(
        [
            shapely.LineString(line).buffer(half_width_m, cap_style="square", join_style="mitre")
            for line in lines
        ]
    )


def walls_round(free: shapely.Geometry) -> list[shapely.Polygon]:
    """A wall around connected ground without islands, in pieces without holes."""
    ring = free.buffer(WALL_M, join_style="mitre").difference(free)
    low_x, low_y, high_x, high_y = ring.bounds
    middle_x = free.representative_point().x
    halves = [shapely.box(low_x, low_y, middle_x, high_y), shapely.box(middle_x, low_y, high_x, high_y)]
    return pieces_of(*(ring.intersection(half) for half in halves))


def pieces_of(*grounds: shapely.Geometry) -> list[shapely.Polygon]:
    """The parts that have an area."""
    parts = [part for ground in grounds for part in shapely.get_parts(ground)]
    return [part for part in parts if part.area > 0.0]


def scene(
    walls: Sequence[shapely.Polygon],
    *,
    robots: int,
    start: tuple[float, float, float],
    goal: Corner,
    time_s_max: float = 240.0,
) -> Scenario:
    """Robots queued behind `start` that see 2 m far, which is less than the depth of every dead end here."""
    queue = shapely.Point(start[0] - SPACING_M * robots, start[1])
    low_x, low_y, high_x, high_y = shapely.union_all([*walls, queue]).bounds
    margin_m = 1.0  # room for a detour
    return placed(
        "dead ends",
        (),
        goal,
        *(polygon(*piece.exterior.coords[:-1]) for piece in walls),
        fleet={
            "robots": robots,
            "robot_radius_m": RADIUS_M,
            "link_length_m_max": 1.0,
            "start": start,
            "spacing_m": SPACING_M,
        },
        law={"epsilon_m": EPSILON_M, "mu0_m": 0.01},
        bounds={
            "x_m_min": low_x - margin_m,
            "y_m_min": low_y - margin_m,
            "x_m_max": high_x + margin_m,
            "y_m_max": high_y + margin_m,
        },
        sensor={"directions": 720, "range_m_max": 2.0, "range_sigma_m": 0.0005},
        drive={"speed_mps": 0.8, "heading_error_rad": 0.0003},
        time={"time_s_max": time_s_max},
    )


def t_junction(robots: int, *, arm_m: float) -> Scenario:
    """The way to the goal begins with the other arm; the arm on the goal's side is bent and closed."""
    stem = [(-0.6 - SPACING_M * robots, 0.0), (0.0, 0.0)]
    dead = [(0.0, 0.0), (0.0, arm_m), (1.0, arm_m)]
    through = [(0.0, 0.0), (0.0, -1.2), (2.2, -1.2), (2.2, arm_m)]
    return scene(
        walls_round(corridors(stem, dead, through)), robots=robots, start=(-0.5, 0.0, 0.0), goal=(2.2, arm_m)
    )


def nested(robots: int) -> Scenario:
    """Behind the first bend there are two more dead ends; one of them is bent again."""
    stem = [(-0.6 - SPACING_M * robots, 0.0), (0.0, 0.0)]
    dead = [(0.0, 0.0), (0.0, 1.8), (1.0, 1.8), (1.0, 1.0)]
    branch = [(0.0, 1.8), (-1.2, 1.8), (-1.2, 2.8)]
    through = [(0.0, 0.0), (0.0, -1.2), (2.4, -1.2), (2.4, 1.8)]
    return scene(
        walls_round(corridors(stem, dead, branch, through)),
        robots=robots,
        start=(-0.5, 0.0, 0.0),
        goal=(2.4, 1.8),
    )


def goal_behind(robots: int) -> Scenario:
    """The robot nearest to the goal stands at a closed end, so the tail has to lead."""
    length_m = 0.6 + SPACING_M * robots
    corridor = [(0.2, 0.0), (-length_m, 0.0), (-length_m, 1.2), (0.0, 1.2)]
    return scene(walls_round(corridors(corridor)), robots=robots, start=(0.0, 0.0, 0.0), goal=(0.0, 1.2))


def pocket(robots: int, *, convex: bool) -> Scenario:
    """A U between start and goal, wider than the strand is long, with plain or jagged walls."""
    width_m, depth_m = 0.6 + SPACING_M * robots + 1.5, 3.0
    top, bottom, back = width_m / 2.0, -width_m / 2.0, depth_m
    u = shapely.LineString([(0.0, bottom), (back, bottom), (back, top), (0.0, top)])
    if convex:
        walls = [
            shapely.LineString(ends).buffer(WALL_M / 2.0, cap_style="square")
            for ends in ((u.coords[0], u.coords[1]), (u.coords[1], u.coords[2]), (u.coords[2], u.coords[3]))
        ]
        walls[1] = walls[1].difference(shapely.union_all([walls[0], walls[2]]))
    else:
        walls = [u.buffer(WALL_M / 2.0, cap_style="square", join_style="mitre")]
    return scene(walls, robots=robots, start=(-0.3, 0.0, 0.0), goal=(back + 0.8, 0.0))


def box(robots: int, *, gap_m: float) -> Scenario:
    """A room with the robots inside, the goal outside and one gap in its wall."""
    length_m = 1.0 + SPACING_M * robots
    room = shapely.box(-length_m, -1.0, 1.0, 1.0)
    ring = room.buffer(WALL_M, join_style="mitre").difference(room)
    hole = shapely.box(0.5, -gap_m / 2.0, 2.0, gap_m / 2.0)
    half = [shapely.box(-99.0, -99.0, 0.0, 99.0), shapely.box(0.0, -99.0, 99.0, 99.0)]
    walls = pieces_of(*(ring.difference(hole).intersection(side) for side in half))
    return scene(walls, robots=robots, start=(0.0, 0.0, 0.0), goal=(2.0, 0.0))
