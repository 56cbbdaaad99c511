"""What the second judge reads: true poses from a run's file, and the scene.

Rule 1: of a run's file only these entries count, which the world writes from what it knows itself: where
        bodies are (`pose.sampled`), and which robots were killed or frozen (`fault.injected`). A robot's word
        counts only where it says that the fault plan killed itself, and the plan has that rule, for that.
Rule 2: formats are read as docs/timeline.md, docs/scenario.md and docs/fields.md describe them.
"""

import json
import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.affinity import rotate, scale, translate

Floats = NDArray[np.float64]
Row = tuple[float, float, float]

HERE, STILL = shapely.Point(0.0, 0.0), ((0.0, 0.0, 0.0),)
ROUND = HERE.buffer(1.0, quad_segs=512)
"""A circle of 1 m with 2048 corners, of which ellipses are made: off by a millionth of the longer axis."""
HARM = {"kill", "freeze"}
STRIKES = HARM | {"restart"}
"""The faults of rules that do such harm."""
UNCERTIFIED = {"printed", "resultant"}  # the paper's laws; every other promises clearance
MOMENT_S = 0.06  # in which a robot moves beside another one, where obstacles move
FAR = 1e9  # no body is so far away [m], and no run so long [s]
DRIFT = 2.0  # a body is off its path by mu0 at most, on each side: twice on one way
BOUNDS = ("x_m_min", "y_m_min", "x_m_max", "y_m_max")


class UnreadableError(Exception):
    """A run that cannot be read; one sentence says why."""


class SceneError(UnreadableError):
    """The scene that was given is what cannot be read."""


@dataclass(frozen=True)
class Solid:
    """A hull or an obstacle: all points near a shape, which may move, but never turns."""

    name: str
    shape: shapely.Geometry
    """Relative to its place on the track."""
    track: Floats
    """Rows of t, x, y in the order of time: straight and even in between; it stands before and after."""
    radius_m: float = 0.0
    """Of an obstacle. Everything inside has the distance 0 from it."""
    hull_m: float = 0.0
    """The radius of a hull. Two hulls that overlap have a negative distance."""


@dataclass(frozen=True, kw_only=True)
class Truth:
    """The true motion of all bodies, the ground, and what has to hold on it."""

    robots: dict[int, Solid]
    unseen: tuple[int, ...]
    """Robots of the fleet, as the header tells it, without any pose."""
    harmed: frozenset[int]
    """Robots that were killed or frozen, as a fault plan or the user asked."""
    obstacles: tuple[Solid, ...]
    movers: tuple[Solid, ...]
    bounds: tuple[float, float, float, float] | None
    """Least x and y, then greatest."""
    goal_m: tuple[float, float] | None
    goal_m_max: float
    """The largest distance from the goal with which it counts as reached."""
    clearance_m: float
    separation_m: float
    behind_m_max: float
    """The largest distance of a robot in place from the ground of the robots ahead, centre to centre."""
    drift_m: float
    """How far apart two bodies may be that drive on one path."""
    speed_mps_max: float
    """Faster than this no body drives."""
    otherwise: tuple[str, ...] = ()
    """In what the scene that was given contradicts the header: it may be that of another run."""


def read(lines: Iterable[bytes], scene: Mapping[str, Any] | None = None) -> Truth:
    """Read the lines of `events.jsonl`.

    Args:
        lines: of the file; the last may be torn.
        scene: a scenario or a `clew-scene/1`, instead of the scenario in the header. What it does not say,
            and the law, which an option may have replaced, is the header's.

    Raises:
        SceneError: the scene is none, or has a number that is not finite.
        UnreadableError: the run cannot be read, or not together with the scene.
    """
    entries, struck = _entries(lines), set[str]()
    poses: dict[int, list[Row]] = defaultdict(list)
    try:
        header = next(entries, None)
        if header is None:
            raise UnreadableError("it is empty: no header of a run")
        rules = (header["faults"] or {}).get("rule", ())
        planned = {rule["name"] for rule in rules if rule["fault"] in STRIKES}
        for entry in entries:
            by_world = entry["source"] == "world"
            if entry["kind"] == "pose.sampled" and by_world:
                poses[entry["robot"]].append((entry["t_s"], entry["x_m"], entry["y_m"]))
            elif entry["kind"] == "fault.injected" and entry["fault"] in HARM:
                by_itself = entry["source"] == entry["process"] and entry["rule"] in planned
                struck |= {entry["process"]} if by_world or by_itself else set()
        scene = None if scene is None else _scenario(scene)
        said = header["scenario"]
        if not math.isfinite(_sum(said)):
            raise UnreadableError("the header has a number that is not finite")
        truth = _truth(said, said["law"]["law"], poses, struck)
        if scene is None:
            return truth
        given = _truth({**said, **scene}, said["law"]["law"], poses, struck)
        before, now = _asked(truth), _asked(given)
        otherwise = tuple(name for name in now if now[name] != before[name])
        return replace(given, unseen=truth.unseen, otherwise=otherwise)
    except (AttributeError, LookupError, TypeError, ValueError, shapely.errors.ShapelyError) as error:
        raise UnreadableError(f"run or scene cannot be read: {type(error).__name__}: {error}") from error


def _entries(lines: Iterable[bytes]) -> Iterator[dict[str, Any]]:
    """The header, and the entries of the two kinds that count."""
    for number, line in enumerate(lines, start=1):
        counts = number == 1 or b'"pose.sampled"' in line or b'"fault.injected"' in line
        if counts and line.endswith(b"\n"):  # else it is the last, and torn
            try:
                entry = json.loads(line)
            except (ValueError, RecursionError) as error:
                raise UnreadableError(f"line {number} cannot be read: {error}") from error
            if number == 1 and not (isinstance(entry, dict) and "scenario" in entry):
                raise UnreadableError("the first line is no header of a run")
            yield entry


def _truth(raw: Mapping[str, Any], law: str, poses: Mapping[int, list[Row]], struck: set[str]) -> Truth:
    fleet, mu0_m, promises = raw["fleet"], raw["law"]["mu0_m"], law not in UNCERTIFIED
    radius_m, goal, bounds = fleet["robot_radius_m"], raw.get("goal"), raw.get("bounds")
    tracks = {robot: np.array(sorted(poses[robot])) for robot in sorted(poses)}
    if wrong := [robot for robot in tracks if not (np.abs(tracks[robot]) <= FAR).all()]:
        raise UnreadableError(f"robot {wrong[0]} has a pose that is not finite, or a number beyond {FAR:g}")
    return Truth(
        robots={each: Solid(f"robot {each}", HERE, tracks[each], hull_m=radius_m) for each in tracks},
        unseen=tuple(robot for robot in range(1, fleet.get("robots", 0) + 1) if robot not in tracks),
        harmed=frozenset(robot for robot in tracks if f"r{robot}" in struck),
        obstacles=tuple(_solid(f"obstacle {n}", each) for n, each in enumerate(raw.get("obstacle") or (), 1)),
        movers=tuple(_solid(f"moving obstacle {each['id']}", each) for each in raw.get("moving") or ()),
        bounds=bounds and tuple(bounds[key] for key in BOUNDS),
        goal_m=goal and tuple(goal["at_m"]),
        goal_m_max=goal["tolerance_m"] + mu0_m if goal else math.inf,
        clearance_m=raw["law"]["epsilon_m"] - mu0_m if promises else 0.0,
        separation_m=max(fleet["separation_m"] - mu0_m, 0.0) if promises else 0.0,
        # Robots keep two radii, `_apart_m` and mu0, come within mu0 of that, and are mu0 off their path.
        behind_m_max=2.0 * radius_m + (_apart_m(raw) if promises else fleet["separation_m"]) + 3.0 * mu0_m,
        drift_m=DRIFT * mu0_m,
        speed_mps_max=raw["drive"]["speed_mps_max"],
    )


def _asked(truth: Truth) -> dict[str, object]:
    """The ground and what has to hold on it, without poses, to compare; names of obstacles do not count."""
    return {
        "obstacles": sorted(map(_written, truth.obstacles)),
        "moving obstacles": sorted(map(_written, truth.movers)),
        "bounds": truth.bounds and [round(each_m, 9) for each_m in truth.bounds],
        "goal": truth.goal_m and [round(each_m, 9) for each_m in (*truth.goal_m, truth.goal_m_max)],
        "radius of robots": {round(each.hull_m, 9) for each in truth.robots.values()},
        "distances to keep": (round(truth.clearance_m, 9), round(truth.separation_m, 9)),
    }


def _written(solid: Solid) -> str:
    shape = shapely.to_wkt(shapely.normalize(solid.shape), rounding_precision=9)
    return f"{shape} {solid.radius_m:.9f} {solid.track.round(9).tolist()}"


def _apart_m(raw: Mapping[str, Any]) -> float:
    """How near hulls come: epsilon, the separation, or, where obstacles move, what one may do in a moment."""
    tracks = [each["track"] for each in raw.get("moving") or ()]
    legs = [leg for track in tracks for leg in pairwise(track)]
    fastest_mps = max((math.dist(a[1:], b[1:]) / (b[0] - a[0]) for a, b in legs), default=0.0)
    said_mps = raw.get("obstacle_speed_mps_max")
    speed_mps = float(fastest_mps if said_mps is None else said_mps)
    moment_m = MOMENT_S * speed_mps + raw["law"]["mu0_m"] if speed_mps > 0.0 else 0.0
    return max(float(raw["law"]["epsilon_m"]), float(raw["fleet"]["separation_m"]), moment_m)


def _solid(name: str, raw: Mapping[str, Any]) -> Solid:
    shape = shapely.Point(raw.get("centre_m", (0.0, 0.0)))
    if raw["shape"] == "polygon":
        shape = shapely.Polygon(raw["vertices_m"])
    elif raw["shape"] == "ellipse":
        turned = rotate(scale(ROUND, *raw["semi_axes_m"]), raw.get("rotation_rad", 0.0), use_radians=True)
        shape = translate(turned, shape.x, shape.y)
    return Solid(name, shape, np.array(raw.get("track", STILL)), radius_m=raw.get("radius_m", 0.0))


def _scenario(scene: Mapping[str, Any]) -> Mapping[str, Any]:
    """The scenario that was given.

    Raises:
        SceneError: it is none; or a number is not finite: no comparison with NaN says that it is less.
    """
    if str(scene.get("schema")).startswith("clew-scene/"):
        scene = _as_scenario(scene)
    if not isinstance(scene.get("fleet"), dict):
        raise SceneError("is neither a scene nor a scenario with one fleet")
    if not math.isfinite(_sum(scene)):
        raise SceneError("has a number that is not finite")
    return scene


def _sum(said: object) -> float:
    """Of the sizes of all numbers: finite if they are."""
    if isinstance(said, Mapping):
        return _sum(list(said.values()))
    if isinstance(said, list):
        return math.fsum(map(_sum, said))
    return abs(said) if isinstance(said, float) else 0.0


def _as_scenario(scene: Mapping[str, Any]) -> dict[str, Any]:
    """The parts of a scenario that a scene stands for (docs/fields.md)."""
    epsilon_m = min(0.05, scene["robot_radius"] / 2.0)
    circles = [{"shape": "circle", "centre_m": at, "radius_m": r} for *at, r in scene["circles"]]
    rings = [*scene["polygons"], *scene.get("walls", ())]
    movers = [{**each, "shape": "circle", "radius_m": each["radius"]} for each in scene.get("moving", ())]
    return {
        "fleet": {"robot_radius_m": scene["robot_radius"], "separation_m": epsilon_m},
        "law": {"epsilon_m": epsilon_m, "mu0_m": epsilon_m / 10.0},
        "goal": {"at_m": scene["goal"], "tolerance_m": scene["goal_tol"]},
        "bounds": dict(zip(BOUNDS, scene["bounds"], strict=True)),
        "obstacle": circles + [{"shape": "polygon", "vertices_m": ring} for ring in rings],
        "moving": movers,
    }
