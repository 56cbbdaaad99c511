"""Worlds of a swarm: small, so that an episode is short; determined by the seed alone. Pure.

Rule 1: in the open, passages are wide enough for a fleet to pass one dead body. In corridors and pockets they
        are not, so `clew.campaign.liveness` must check whether there was a way.
"""

import math
from enum import StrEnum
from typing import Any

from clew.fields.built import rectangle
from clew.fields.field import Field, scene
from clew.fields.kinds import Kind
from clew.swarm.draws import Draws
from protocol.files.reading import understand
from world.scenario.deployment import deployed
from world.scenario.scenario import Scenario
from world.scenario.scene import as_scenario

RADIUS_M = 0.15  # as in most scenes from public data
ROBOTS = (3, 5)  # three is the least with a middle; five is the paper's number, and the most that fit
OPEN_M = (4.0, 3.0)
OPEN_WIDTH_M = 1.2  # twice 2 (r + epsilon) with a body between is 1.1 m, plus a margin
OPEN_DENSITY = 0.04
CORRIDORS_M = (3.2, 2.2)  # four columns and three rows
CORRIDOR_WIDTH_M = 0.6
DIRECTIONS = 180  # in a small field as good as 360, at half the cost
SHORT_RANGE_M = 1.2  # a leader that sees no further drives into a pocket
OTHER_SEPARATIONS_M = (0.02, 0.1)  # less and more than epsilon
OTHER_SEPARATION = 0.2  # of all seeds
WALKER = 0.2  # of the seeds with a walker where one is allowed
NO_GOAL = 0.2  # of the same seeds; the leader then takes the widest gap, step by step
WALKER_M = 0.2  # the radius of a person, as in `launch/scenarios/pedestrian.toml`
WALKER_AWAY_M = 1.0  # from every robot, at first
WALKER_MPS = (0.1, 0.4)  # slower than the robots
WALKER_PAUSE_S = (0.1, 3.0)
SOURCE = "swarm"


class Ground(StrEnum):
    """The kind of world."""

    OPEN = "open"
    SCATTERED = "scattered"
    """Open; the robots start anywhere, so that they line up by turns."""
    CORRIDORS = "corridors"
    POCKET = "pocket"
    """A dead end, one robot wide, is in the way, so that the strand turns round."""


SHARES = (Ground.OPEN,) * 6 + (Ground.SCATTERED,) * 7 + (Ground.CORRIDORS,) * 3 + (Ground.POCKET,) * 4


def draw_world(
    seed: int, *, time_s_max: float, queue: bool = False, must_arrive: bool = True
) -> tuple[Ground, dict[str, Any]]:
    """A world, as in a scenario file.

    Args:
        seed: decides all that is drawn.
        time_s_max: how long a run may last.
        queue: whether it is to be open, and to have the largest number of robots.
        must_arrive: whether there has to be a goal, and nobody who walks about.
    """
    draws = Draws(seed, "swarm/world")
    ground = Ground.OPEN if queue else draws.pick(SHARES)
    drawn = _draw_scene(ground, seed, draws)
    raw = as_scenario(drawn, SOURCE)
    raw["name"] = f"swarm-{seed}"
    raw["fleet"]["robots"] = ROBOTS[1] if queue else draws.whole(*ROBOTS)
    if (margins := Draws(seed, "swarm/margins")).chance(OTHER_SEPARATION):
        raw["fleet"]["separation_m"] = margins.pick(OTHER_SEPARATIONS_M)
    raw["sensor"]["directions"] = DIRECTIONS
    raw["time"]["time_s_max"] = time_s_max
    if ground is Ground.POCKET:
        raw["sensor"]["range_m_max"] = SHORT_RANGE_M
    if ground is Ground.SCATTERED:
        raw = deployed(raw | {"fleet": raw["fleet"] | {"deployment": "random"}}, seed=seed, source=SOURCE)
    if must_arrive or queue:
        return ground, raw
    if (walks := Draws(seed, "swarm/walker")).chance(WALKER):
        raw["moving"] = [_walker(raw, walks, time_s_max)]
    if Draws(seed, "swarm/goal").chance(NO_GOAL):
        del raw["goal"]
    return ground, raw


def as_loaded(raw: dict[str, Any]) -> Scenario:
    """The scenario, loaded as from a file."""
    return understand(raw, Scenario, SOURCE)


def _walker(raw: dict[str, Any], draws: Draws, until_s: float) -> dict[str, Any]:
    """Somebody who walks from place to place, and stops a while at each."""
    bounds, speed_mps = raw["bounds"], draws.between(*WALKER_MPS)
    robots = [(pose.x_m, pose.y_m) for pose in as_loaded(raw).fleet.poses()]

    def place() -> tuple[float, float]:
        return (
            draws.between(bounds["x_m_min"] + WALKER_M, bounds["x_m_max"] - WALKER_M),
            draws.between(bounds["y_m_min"] + WALKER_M, bounds["y_m_max"] - WALKER_M),
        )

    at, t_s = place(), 0.0
    while any(math.dist(at, robot) < WALKER_AWAY_M for robot in robots):
        at = place()
    track = [(t_s, *at)]
    while t_s < until_s:
        to = place()
        t_s = round(t_s + math.dist(at, to) / speed_mps + draws.between(*WALKER_PAUSE_S), 3)
        at = to
        track.append((t_s, *at))
    return {"id": "walker", "shape": "circle", "radius_m": WALKER_M, "track": [list(each) for each in track]}


def _draw_scene(ground: Ground, seed: int, draws: Draws) -> dict[str, Any]:
    if ground is Ground.CORRIDORS:
        field = Field(
            kind=Kind.CORRIDORS,
            seed=seed,
            robot_radius_m=RADIUS_M,
            least_width_m=CORRIDOR_WIDTH_M,
            size_m=CORRIDORS_M,
        )
        return scene(field)
    if ground is Ground.POCKET:
        return _pocket(seed, draws)
    kind = draws.pick((Kind.CIRCLES, Kind.CONVEX, Kind.MIXED))
    return scene(_open(kind, seed, OPEN_DENSITY))


def _open(kind: Kind, seed: int, density: float) -> Field:
    return Field(
        kind=kind,
        seed=seed,
        robot_radius_m=RADIUS_M,
        density=density,
        least_width_m=OPEN_WIDTH_M,
        size_m=OPEN_M,
    )


def _pocket(seed: int, draws: Draws) -> dict[str, Any]:
    """An empty field with a dead end in the straight way."""
    drawn = scene(_open(Kind.CIRCLES, seed, 0.0))
    y_m = drawn["start"][1]
    from_m, depth_m, half_m = draws.between(0.4, 1.0), draws.between(1.3, 2.2), draws.between(0.28, 0.36)
    to_m, wall_m = from_m + depth_m, RADIUS_M
    walls = [
        rectangle(from_m, to_m, y_m + half_m, y_m + half_m + wall_m),
        rectangle(from_m, to_m, y_m - half_m - wall_m, y_m - half_m),
        rectangle(to_m, to_m + wall_m, y_m - half_m - wall_m, y_m + half_m + wall_m),
    ]
    return drawn | {"polygons": walls}
