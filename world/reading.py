"""From a file to checked types; whatever is wrong becomes one line that names file, path, bound and value."""

import re
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from protocol.errors import UsageError

SCENARIOS = Path(__file__).parent.parent / "launch" / "scenarios"
T = TypeVar("T")

# How msgspec words its refusals: what is wrong, then where, unless it is the whole.
_REFUSAL = re.compile(r"(?P<what>.*?)(?: - at `\$(?P<path>.*)`)?", re.DOTALL)
_BOUND = re.compile(r"Expected `\w+` (?P<bound>[<>]=? \S+)")
_UNIT = re.compile(r"_(?P<unit>m|rad|mps|radps|s)(?:_min|_max)?(?:\[\d+\])?$")
_UNIT_NAMES = {"m": " m", "rad": " rad", "mps": " m/s", "radps": " rad/s", "s": " s"}


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


def read(path: Path) -> dict[str, Any]:
    """What a TOML or JSON file says, unchecked."""
    try:
        text = path.read_bytes()
        said = msgspec.toml.decode(text) if path.suffix == ".toml" else msgspec.json.decode(text)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise UsageError(f"{path.name}: is not {path.suffix[1:].upper()}: {error}") from error
    if not isinstance(said, dict):
        raise UsageError(f"{path.name}: $: must be an object, got {_short(said)}")
    return said


def understand(raw: object, wanted: type[T], source: str) -> T:
    """The raw value as the wanted type; `source` names it in refusals."""
    try:
        return msgspec.convert(raw, wanted)
    except msgspec.ValidationError as error:
        raise UsageError(f"{source}: {_one_line(str(error), raw)}") from error


def _one_line(refusal: str, raw: object) -> str:
    """What msgspec refuses, with the value that it leaves out: `$.fleet.robots: must be >= 1, got 0`."""
    parts = _REFUSAL.fullmatch(refusal)
    assert parts is not None, refusal
    what, path = parts["what"], parts["path"]
    if path is None:  # one of our own relations, which says its path itself, or the whole
        return what if what.startswith("$") else f"$: {what}"
    bound, unit = _BOUND.fullmatch(what), _UNIT.search(path)
    if bound is not None:
        what = f"must be {bound['bound']}{_UNIT_NAMES[unit['unit']] if unit else ''}"
    got = "" if ", got" in what or what.startswith("Object") else f", got {_short(_at(raw, path))}"
    return f"${path}: {what}{got}"


def _at(raw: object, path: str) -> object:
    """The value at one of msgspec's paths, `.fleet.places[2]`."""
    for key, index in re.findall(r"\.(\w+)|\[(\d+)\]", path):
        assert isinstance(raw, dict | list | tuple), path  # msgspec has been there before us
        raw = raw[key or int(index)]
    return raw


def _short(value: object) -> str:
    said = repr(value)
    return said if len(said) <= 60 else f"{said[:57]}..."
