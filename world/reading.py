"""From a file to checked types; whatever is wrong becomes one line that names file, path, bound and value."""

from pathlib import Path
from typing import Any, TypeVar

import msgspec

from protocol.errors import UsageError
from world.refusals import one_line, short

SCENARIOS = Path(__file__).parent.parent / "launch" / "scenarios"
T = TypeVar("T")


def find(name_or_path: str) -> Path:
    """The file of a scenario: by its name in launch/scenarios, or by its own path."""
    path = Path(name_or_path)
    if path.suffix in {".toml", ".json"}:
        return path
    known = {kept.stem: kept for kept in sorted(SCENARIOS.glob("*.toml"))}
    if name_or_path not in known:
        raise UsageError(
            f"unknown scenario {name_or_path!r}: must be one of {', '.join(known)}, or a .toml or .json file"
        )
    return known[name_or_path]


def read(path: Path, source: str) -> dict[str, Any]:
    """What a TOML or JSON file says, unchecked; `source` names it in refusals."""
    try:
        text = path.read_bytes()
        said = msgspec.toml.decode(text) if path.suffix == ".toml" else msgspec.json.decode(text)
    except OSError as error:
        raise UsageError(f"{source}: cannot be read: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise UsageError(f"{source}: is not {path.suffix[1:].upper()}: {error}") from error
    if not isinstance(said, dict):
        raise UsageError(f"{source}: $: must be an object, got {short(said)}")
    return said


def understand(raw: object, wanted: type[T], source: str) -> T:
    """The raw value as the wanted type; `source` names it in refusals."""
    try:
        return msgspec.convert(raw, wanted)
    except msgspec.ValidationError as error:
        raise UsageError(f"{source}: {one_line(str(error), raw, wanted)}") from error
