"""Finds the file of a scenario."""

from pathlib import Path

from protocol.errors import UsageError
from protocol.files.names import did_you_mean
from protocol.root import LAUNCH

SCENARIOS = LAUNCH / "scenarios"
FLEETS = SCENARIOS / "fleets"  # scenarios with several fleets


def find(name_or_path: str) -> Path:
    """The file of a scenario, by its name in launch/scenarios, or in its folder `fleets`, or by its path."""
    path = Path(name_or_path)
    if path.suffix in {".toml", ".json"}:
        return path
    known = {kept.stem: kept for folder in (SCENARIOS, FLEETS) for kept in sorted(folder.glob("*.toml"))}
    if name_or_path not in known:
        raise UsageError(
            f"unknown scenario {name_or_path!r}: must be one of {', '.join(known)}, or a .toml or .json file"
            f"{did_you_mean(name_or_path, known)}"
        )
    return known[name_or_path]
