"""The first line of a log, the header, which says what was run.

Rule 1: a file is no log if its first line is no header of ours and its second line is no entry.
Rule 2: fields that the header lacks, or that cannot be read, are unknown.
"""

import re
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from protocol.errors import UNREADABLE, UsageError
from protocol.frames import ROBOTS_MAX
from protocol.plain import plain
from protocol.run_settings import read_plan, read_settings
from world.record.lines import Stamp
from world.record.recorder import SCHEMA, Header
from world.record.run_files import as_header, read_scenario

HEADER_KIND = Header.__struct_config__.tag
UNKNOWN = Header(
    run="unknown",
    seed=0,
    speed=None,
    started_at="1970-01-01T00:00:00+00:00",
    scenario={},
    scenario_hash="unknown",
    versions={},
)


class Stamped(Stamp, frozen=True, kw_only=True):
    """What every line has, also of a kind that this program does not know."""

    kind: str


class _Versioned(Struct, frozen=True):
    schema: str


def header_of(first: bytes, second: bytes, path: Path) -> tuple[Header, str | None]:
    """The header of the file that begins with these two lines, and what is wrong with it.

    Raises:
        UsageError: rule 1.
    """
    header, damage = header_or_rest(first, path)
    if damage is not None and not is_entry(first) and not is_entry(second):
        read_header(first, path)
    return header, damage


def header_or_rest(first: bytes, path: Path) -> tuple[Header, str | None]:
    """As much of the header as the first line says, and what is wrong with it."""
    try:
        return read_header(first, path), None
    except UsageError as error:
        return _salvaged(first, path.parent), plain(f"line 1 is damaged: {error}; what it lacks is unknown")


def read_header(text: bytes, path: Path) -> Header:
    """The header in the first line of this file, also of another version of our schema.

    Raises:
        UsageError: it is no header of ours.
    """
    if not text:
        raise UsageError(f"{path}: it is empty: no header of a run")
    schema = SCHEMA
    try:
        schema = msgspec.json.decode(text, type=_Versioned).schema
        header = msgspec.json.decode(text, type=Header)
    except UNREADABLE as error:
        if schema == SCHEMA:
            raise UsageError(f"{path}: the first line is no header of a run: {error}") from error
        raise UsageError(f"{path}: {other(schema)}, and its header cannot be read: {error}") from error
    if not re.fullmatch(r"clew-timeline/\d+", schema):
        raise UsageError(f"{path}: {other(schema)}")
    return header


def robots_of(header: Header) -> int:
    """How many robots there are; with a damaged header, how many a fleet may have."""
    match header.scenario:
        case {"fleet": {"robots": int(robots)}}:
            return robots
        case _:
            return ROBOTS_MAX


def is_entry(text: bytes) -> bool:
    """Whether a line has the fields that all entries have; the header is no entry."""
    try:
        return msgspec.json.decode(text, type=Stamped).kind != HEADER_KIND
    except UNREADABLE:
        return False


def other(schema: str) -> str:
    """Say that this program reads another schema."""
    return f"its schema is {schema!r}, this program reads {SCHEMA!r}"


def _salvaged(text: bytes, folder: Path) -> Header:
    """The readable fields of a damaged header, and fields from other files of the run."""
    try:
        raw = {} if is_entry(text) else msgspec.json.decode(text, type=dict[str, Any])
    except UNREADABLE:
        return UNKNOWN
    good: dict[str, Any] = _from_files(folder)
    for field in msgspec.structs.fields(Header):
        if field.name in raw:
            try:
                good[field.name] = msgspec.convert(raw[field.name], field.type)
            except UNREADABLE:
                continue
    return msgspec.structs.replace(UNKNOWN, **good)


def _from_files(folder: Path) -> dict[str, Any]:
    """Fields of the header from the files that the run began with; none, if one is missing or damaged."""
    try:
        scenario, settings, plan = read_scenario(folder), read_settings(folder), read_plan(folder)
    except UsageError:
        return {}
    return {
        "scenario": msgspec.to_builtins(scenario),
        "scenario_hash": scenario.fingerprint(),
        "seed": settings.seed,
        "speed": settings.speed,
        "faults": as_header(plan),
    }
