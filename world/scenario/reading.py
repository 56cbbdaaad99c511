"""Finds the file of a scenario, and the law that it names."""

from pathlib import Path
from typing import Any

from protocol import laws
from protocol.errors import UsageError
from protocol.faults import plan
from protocol.files.names import did_you_mean
from protocol.files.reading import read
from protocol.law_files import named
from protocol.root import LAUNCH
from protocol.run_settings import SCENARIO_FILE

SCENARIOS = LAUNCH / "scenarios"
FLEETS = SCENARIOS / "fleets"  # scenarios with several fleets
MAP_IMAGES = {".pgm", ".png", ".bmp"}  # which maps of ROS have beside their YAML files


def find(name_or_path: str) -> Path:
    """The file of a scenario, by its name in launch/scenarios, or in its folder `fleets`, or by its path."""
    path = Path(name_or_path)
    if path.suffix in {".toml", ".json"}:
        return path
    known = {kept.stem: kept for folder in (SCENARIOS, FLEETS) for kept in sorted(folder.glob("*.toml"))}
    if name_or_path in known:
        return known[name_or_path]
    if path.suffix in {".yaml", ".yml"}:
        raise UsageError(f"{name_or_path}: `clew map {name_or_path}` makes a scene of a map of ROS")
    if path.suffix in MAP_IMAGES:
        raise UsageError(f"{name_or_path}: `clew map` makes a scene of the YAML file of a map of ROS")
    if name_or_path in plan.shipped():
        raise UsageError(f"{name_or_path!r} is a fault plan, not a scenario: --faults {name_or_path}")
    if (path / SCENARIO_FILE).is_file():
        raise UsageError(f"{name_or_path}: is the folder of a run; its scenario is {path / SCENARIO_FILE}")
    raise UsageError(
        f"unknown scenario {name_or_path!r}: must be one of {', '.join(known)}, or a .toml or .json file"
        f"{did_you_mean(name_or_path, known)}"
    )


def read_found(name_or_path: str) -> tuple[Path, dict[str, Any]]:
    """The file of a scenario or a scene, and its content, unchecked.

    Raises:
        UsageError: there is none, it cannot be read, or it is a fault plan.
    """
    path = find(name_or_path)
    said = read(path, name_or_path)
    if plan.is_plan(said):
        raise UsageError(f"{name_or_path!r} is a fault plan, not a scenario: --faults {name_or_path}")
    return path, said


def law_in(raw: dict[str, Any]) -> str | None:
    """The law as a scenario names it; None: it names none."""
    section = raw.get("law")
    said = section.get("law") if isinstance(section, dict) else None
    return said if isinstance(said, str) else None


def name_law(raw: dict[str, Any], folder: Path, source: str) -> None:
    """Put the whole name of the law into a scenario; the path of a law's file is from this folder.

    Raises:
        UsageError: the law is not here; a log of a run under it can be read nevertheless.
    """
    if (said := law_in(raw)) is None:
        return
    try:
        raw["law"]["law"] = name = named(said, folder)
        laws.check(name)
    except UsageError as error:
        raise UsageError(f"{source}: $.law.law: {error}") from error
