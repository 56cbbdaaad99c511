"""The scenes of a campaign: the files below its folders, and copies with a robot that barely fits.

Rule 1: a scene's family is the name of the folder that holds its file.
Rule 2: a changed scene is written to a file, so that a single rehearsal can replay it.
Rule 3: a file below a folder that was meant as a scene or scenario, and cannot be read as one, is told of;
        so is one with several fleets, which a campaign does not play.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from protocol.errors import UsageError
from protocol.faults.plan_text import FAULTS_FILE
from protocol.files.names import did_you_mean
from protocol.files.opening import WRITTEN_BYTES_MAX, read_bytes
from protocol.files.reading import decode
from protocol.files.writing import make_folder, would_be_lost, write_whole
from protocol.law_files import named
from protocol.run_settings import SETTINGS_FILE
from world.scenario.reading import find, law_in
from world.scenario.scenario import Scenario, load
from world.scenario.scene import EPSILON_M_MAX, EPSILON_RADII, ROBOTS

SCENE_SCHEMA = "clew-scene/1"
SUFFIXES = {".json", ".toml"}
NEVER_SCENES = (FAULTS_FILE, SETTINGS_FILE, "pyproject.toml")
"""How the names of files end that may lie beside scenes, also of `one.faults.toml`."""
OF_SCENE = frozenset({"robot_radius", "start", "goal", "circles", "polygons"})
OF_SCENARIO = frozenset({"law", "sensor", "drive", "time", "goal", "bounds", "obstacle", "moving"})
COMMON = 2  # so many of these names: a file for something else may have one by chance
SPARE = 1.05  # a scene counts as solvable with 5 % to spare


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """A file to rehearse."""

    path: Path
    family: str
    robots: int | None
    """Replaces the scenario's own number."""
    robots_left_out: int = 0
    """Robots without room at the start."""
    widest_path_radius_m: float | None
    """The radius of the largest disc that can be moved from start to goal; None: not in the file."""
    law: str | None
    """The whole name of the law in the file: that of a law's file has a hash of its content."""


def find_scenes(roots: Sequence[Path], robots: int | None, warn: Callable[[str], None]) -> list[Scene]:
    """All scenes and scenarios among these files and below these folders; rule 3 warns of the others.

    Raises:
        UsageError: there are none, or one of the roots cannot be read.
    """
    broken: list[str] = []
    scenes = [scene for root in roots for scene in _below(root, robots, broken)]
    if not scenes:
        more = "".join(f"; {each}" for each in broken)
        raise UsageError(f"no scene (.json) and no scenario (.toml) in {', '.join(map(str, roots))}{more}")
    for each in broken:
        warn(f"not played: {each}")
    return scenes


def check_widest(scenes: Iterable[Scene]) -> None:
    """Refuse scenes that cannot be made tight, before any file is written.

    Raises:
        UsageError: a scene does not contain the width of its widest path.
    """
    for scene in scenes:
        if scene.widest_path_radius_m is None:
            raise UsageError(f"--tight: {scene.path}: has no stats.widest_path_radius")


def tighten(scene: Scene, share: float, folder: Path, deployment: str | None, *, is_ours: bool) -> Scene:
    """Write the scene with a robot whose `r + epsilon` is this share of the widest path.

    If the queue of robots at the start does not fit any more, the scene gets fewer robots.

    Raises:
        UsageError: the scene itself is in the place of the new file, or another file in a folder not ours.
    """
    assert scene.widest_path_radius_m is not None, "`check_widest` has checked it"
    raw = _read(scene.path)
    path = folder / scene.family / scene.path.name
    if path.exists() and (path.samefile(scene.path) or not (is_ours or _is_same(path, raw))):
        raise would_be_lost(path)
    make_folder(path.parent)
    radius_m = tight_radius_m(share * scene.widest_path_radius_m)
    write_whole(path, msgspec.json.encode({**raw, "robot_radius": radius_m}))
    asked = scene.robots or ROBOTS
    robots = next((robots for robots in range(asked, 0, -1) if _is_accepted(path, robots, deployment)), asked)
    return replace(scene, path=path, robots=robots, robots_left_out=asked - robots)


def _is_same(path: Path, raw: dict[str, Any]) -> bool:
    """Whether a file is empty, or has this scene, perhaps with another robot."""
    return path.stat().st_size == 0 or _read(path) | {"robot_radius": 0.0} == raw | {"robot_radius": 0.0}


def tight_radius_m(closest_m: float) -> float:
    """The radius r of the robot with r + epsilon(r) = `closest_m`."""
    capped_m = closest_m - EPSILON_M_MAX
    return capped_m if capped_m * EPSILON_RADII >= EPSILON_M_MAX else closest_m / (1.0 + EPSILON_RADII)


def solvable(widest_path_radius_m: float | None, scenario: Scenario) -> bool | None:
    """Whether there is a way for the robot; None: not known, or too close to decide."""
    if widest_path_radius_m is None:
        return None
    if widest_path_radius_m > SPARE * scenario.closest_m:
        return True
    return False if widest_path_radius_m < scenario.closest_m else None


def _below(root: Path, robots: int | None, broken: list[str]) -> Iterator[Scene]:
    if not root.exists() and (root.suffix or len(root.parts) > 1):
        raise UsageError(f"{root}: no such folder or file")
    if not root.exists():
        root = find(str(root))
    paths = [root] if root.is_file() else sorted(root.rglob("*"))
    for path in paths:
        if path.suffix in SUFFIXES and path.is_file():
            raw = _read(path)
            is_scene = raw.get("schema") == SCENE_SCHEMA or "fleet" in raw
            if path == root and not is_scene:
                load(str(path))  # refuses it, and says what it is, such as a fault plan
            if (is_scene or path == root) and not isinstance(raw.get("fleet"), list):
                yield Scene(
                    path=path,
                    family=path.resolve().parent.name,
                    robots=robots,
                    widest_path_radius_m=_widest_m(raw),
                    law=_law(path, raw),
                )
            elif (why := _flaw(path, raw)) is not None:
                broken.append(why)


def _flaw(path: Path, raw: dict[str, Any]) -> str | None:
    """Rule 3: why this file is no scene and no scenario; None: it was not meant as one."""
    if path.name.endswith(NEVER_SCENES):
        return None
    try:
        if not raw:
            decode(read_bytes(path, WRITTEN_BYTES_MAX), path.suffix)
        elif _is_meant(path, raw):
            load(str(path))
    except UsageError as error:
        return str(error)
    except ValueError as error:
        return f"{path}: is not {path.suffix[1:].upper()}: {error}"
    return None


def _is_meant(path: Path, raw: dict[str, Any]) -> bool:
    if path.suffix == ".json":
        return str(raw.get("schema")).startswith("clew-scene") or len(OF_SCENE & raw.keys()) >= COMMON
    return len(OF_SCENARIO & raw.keys()) >= COMMON or did_you_mean("fleet", raw) != ""


def _read(path: Path) -> dict[str, Any]:
    """The content of the file; empty if it is not an object, which the loader reports later."""
    try:
        said = decode(read_bytes(path, WRITTEN_BYTES_MAX), path.suffix)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError:
        return {}
    return said if isinstance(said, dict) else {}


def _widest_m(raw: dict[str, Any]) -> float | None:
    stats = raw.get("stats")
    widest_m = stats.get("widest_path_radius") if isinstance(stats, dict) else None
    return float(widest_m) if isinstance(widest_m, int | float) else None


def _law(path: Path, raw: dict[str, Any]) -> str | None:
    said = law_in(raw)
    try:
        return None if said is None else named(said, path.parent)
    except UsageError:
        return None  # the episode reports why


def _is_accepted(path: Path, robots: int, deployment: str | None) -> bool:
    """Whether the loader accepts the scene. If it accepts no number of robots, the episode reports why."""
    try:
        load(str(path), robots=robots, deployment=deployment)
    except UsageError:
        return False
    return True
