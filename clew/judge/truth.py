"""What the second judge reads: true poses from a run's file, and the scene.

Rule 1: of a run's file only these entries count, which the world writes from what it knows itself: where
        bodies are (`pose.sampled`), and which robots were killed or frozen (`fault.injected`). A robot's word
        counts only where it says that the fault plan killed it, and the plan has that rule.
Rule 2: formats are read as docs/timeline.md, docs/scenario.md and docs/fields.md describe them.
"""

import json
import math
import re
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.affinity import rotate, translate

Floats = NDArray[np.float64]

ELLIPSE_CORNERS = 2048  # the polygon is off the ellipse by a millionth of its longer axis
HARM = {"kill", "freeze"}
UNCERTIFIED = {"printed", "resultant"}  # the paper's laws; every other promises clearance
DRIFT = 2.0  # a body is off its path by mu0 at most, on each side: twice on one way
BOUNDS = ("x_m_min", "y_m_min", "x_m_max", "y_m_max")


class UnreadableError(Exception):
    """A run or a scene that cannot be read; one sentence says why."""


@dataclass(frozen=True, kw_only=True)
class Run:
    """The true motion of all bodies."""

    poses: dict[int, Floats]
    """By robot: rows of t, x, y in the order of time; in between the body moved straight and evenly."""
    harmed: frozenset[int]
    """Robots that were killed or frozen, as a fault plan or the user asked."""
    scenario: dict[str, Any]
    """As in the header."""


@dataclass(frozen=True, kw_only=True)
class Obstacle:
    """A polygon, or a point with a radius; if it moves, relative to its place on its track."""

    name: str
    shape: shapely.Geometry
    radius_m: float
    track: Floats
    """Rows of t, x, y; it stands before the first and after the last. Empty: it never moves."""


@dataclass(frozen=True, kw_only=True)
class Scene:
    """The ground, and what has to hold on it."""

    obstacles: tuple[Obstacle, ...]
    movers: tuple[Obstacle, ...]
    bounds: tuple[float, float, float, float] | None
    """Least x and y, then greatest."""
    goal_m: tuple[float, float] | None
    goal_m_max: float
    """The largest distance from the goal with which it counts as reached."""
    radius_m: float
    clearance_m: float
    separation_m: float
    behind_m_max: float
    """The largest distance of a robot in place from the ground of the robots ahead, centre to centre."""
    drift_m: float
    """How far apart two bodies may be that drive on one path."""
    speed_mps_max: float
    """Faster than this no body drives."""


def read_run(lines: Iterable[bytes]) -> Run:
    """Read the lines of `events.jsonl`; only the last may be torn.

    Raises:
        UnreadableError: it is no run, or a line cannot be read.
    """
    entries = _entries(lines)
    try:
        header = next(entries, {})
        if header.get("kind") != "run.started":
            raise UnreadableError("the first line is not the header of a run")
        planned = {rule["name"] for rule in (header["faults"] or {}).get("rule", ())}
        poses: dict[int, list[tuple[float, float, float]]] = defaultdict(list)
        harmed = set()
        for entry in entries:
            by_world = entry["source"] == "world"
            if entry["kind"] == "pose.sampled" and by_world:
                poses[entry["robot"]].append((entry["t_s"], entry["x_m"], entry["y_m"]))
            elif entry["kind"] == "fault.injected" and (by_world or entry["rule"] in planned):
                robot = re.fullmatch(r"r(\d+)", entry["process"] or "")
                harmed |= {int(robot[1])} if robot and entry["fault"] in HARM else set()
        return Run(
            poses={robot: np.array(sorted(rows)) for robot, rows in sorted(poses.items())},
            harmed=frozenset(harmed),
            scenario=header["scenario"],
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise UnreadableError(f"an entry lacks something: {type(error).__name__}: {error}") from error


def _entries(lines: Iterable[bytes]) -> Iterator[dict[str, Any]]:
    """The header, and the entries of the two kinds that count."""
    torn = None
    for number, line in enumerate(lines, start=1):
        if torn is not None:
            raise UnreadableError(f"line {torn} cannot be read")
        if number == 1 or b'"pose.sampled"' in line or b'"fault.injected"' in line:
            try:
                yield json.loads(line)
            except ValueError:
                torn = number


def read_scene_file(path: Path) -> dict[str, Any]:
    """The content of a scenario (TOML) or a scene (JSON).

    Raises:
        UnreadableError: it cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
        said = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
    except (OSError, ValueError) as error:
        raise UnreadableError(f"{path}: {error}") from error
    if not isinstance(said, dict):
        raise UnreadableError(f"{path}: is neither a scenario nor a scene")
    return said


def scene_of(run: Run, raw: dict[str, Any] | None = None) -> Scene:
    """The scene of a run: as in a scenario or a `clew-scene/1`, or without one as in the run's header.

    What the file does not say, and the law, which an option may have replaced, are the header's.

    Raises:
        UnreadableError: it lacks something, or something is not as it should be.
    """
    try:
        if raw is not None and str(raw.get("schema", "")).startswith("clew-scene/"):
            raw = _as_scenario(raw)
        return _scene({**run.scenario, **(raw or {})}, run.scenario["law"]["law"])
    except (KeyError, IndexError, TypeError, ValueError, shapely.errors.ShapelyError) as error:
        raise UnreadableError(f"the scene cannot be read: {type(error).__name__}: {error}") from error


def _scene(raw: dict[str, Any], law: str) -> Scene:
    fleet, mu0_m = raw["fleet"], raw["law"]["mu0_m"]
    promises, bounds, goal = law not in UNCERTIFIED, raw.get("bounds"), raw.get("goal")
    obstacles = enumerate(raw.get("obstacle") or (), start=1)
    return Scene(
        obstacles=tuple(_obstacle(f"obstacle {number}", each) for number, each in obstacles),
        movers=tuple(_obstacle(f"moving obstacle {each['id']}", each) for each in raw.get("moving") or ()),
        bounds=bounds and tuple(bounds[key] for key in BOUNDS),
        goal_m=goal and tuple(goal["at_m"]),
        goal_m_max=goal["tolerance_m"] + mu0_m if goal else math.inf,
        radius_m=fleet["robot_radius_m"],
        clearance_m=raw["law"]["epsilon_m"] - mu0_m if promises else 0.0,
        separation_m=max(fleet["separation_m"] - mu0_m, 0.0) if promises else 0.0,
        # Robots keep two radii, the separation and mu0, come within mu0 of that, and are mu0 off their path.
        behind_m_max=2.0 * fleet["robot_radius_m"] + fleet["separation_m"] + 3.0 * mu0_m,
        drift_m=DRIFT * mu0_m,
        speed_mps_max=raw["drive"]["speed_mps_max"],
    )


def _obstacle(name: str, raw: dict[str, Any]) -> Obstacle:
    x_m, y_m = raw.get("centre_m", (0.0, 0.0))
    shape: shapely.Geometry = shapely.Point(x_m, y_m)
    if raw["shape"] == "polygon":
        shape = shapely.Polygon(raw["vertices_m"])
    elif raw["shape"] == "ellipse":
        bearings = np.linspace(0.0, math.tau, ELLIPSE_CORNERS, endpoint=False)
        ring = np.stack([np.cos(bearings), np.sin(bearings)], axis=1) * raw["semi_axes_m"]
        turned = rotate(shapely.Polygon(ring), raw.get("rotation_rad", 0.0), origin=(0, 0), use_radians=True)
        shape = translate(turned, x_m, y_m)
    track = np.array(raw.get("track", ()), dtype=np.float64)
    return Obstacle(name=name, shape=shape, radius_m=raw.get("radius_m", 0.0), track=track)


def _as_scenario(raw: dict[str, Any]) -> dict[str, Any]:
    """The parts of a scenario that a scene stands for (docs/fields.md)."""
    radius_m = raw["robot_radius"]
    epsilon_m = min(0.05, radius_m / 2.0)
    rings = [*raw["polygons"], *raw.get("walls", ())]
    return {
        "fleet": {"robot_radius_m": radius_m, "separation_m": epsilon_m},
        "law": {"epsilon_m": epsilon_m, "mu0_m": epsilon_m / 10.0},
        "goal": {"at_m": raw["goal"], "tolerance_m": raw["goal_tol"]},
        "bounds": dict(zip(BOUNDS, raw["bounds"], strict=True)),
        "obstacle": [
            *({"shape": "circle", "centre_m": (x, y), "radius_m": r} for x, y, r in raw["circles"]),
            *({"shape": "polygon", "vertices_m": ring} for ring in rings),
        ],
        "moving": [
            {"shape": "circle", "id": each["id"], "radius_m": each["radius"], "track": each["track"]}
            for each in raw.get("moving", ())
        ],
    }
