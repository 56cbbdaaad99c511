"""Numbers about a timeline, and the verdict beside it."""

from collections import Counter
from pathlib import Path
from typing import Any

import msgspec
from msgspec import Struct

from clew.log.log import Log
from clew.log.timeline import Timeline
from protocol.plain import plain
from protocol.timeline import kind_of
from world.judge.verdict import VERDICT_FILE, Verdict
from world.record.recorder import EVENTS_FILE
from world.record.run_files import read_verdict


class Judged(Struct, frozen=True, kw_only=True):
    """The head of a verdict."""

    ok: bool
    exit_code: int
    reason: str


class Summary(Struct, frozen=True, kw_only=True):
    """What `clew log info` prints; null: the log does not say."""

    run: str
    folder: str
    """The folder of the log."""
    scenario: str | None
    law: str | None
    robots: int | None
    seed: int
    scenario_hash: str
    versions: dict[str, str]
    sim_s: float | None
    """From the verdict: until the run was over."""
    last_entry_s: float
    """Simulated time of the newest entry, which may be later than the end of the run."""
    ended: str | None
    verdict: Judged | None
    entries: int
    sources: dict[str, int]
    kinds: dict[str, int]
    flaws: tuple[str, ...]


def summarise(read: Timeline | Log, run: Path) -> Summary:
    """The summary of a timeline from this folder, or from its `events.jsonl`."""
    header = read.header
    verdict, flaws = verdict_beside(run / EVENTS_FILE if run.is_dir() else run)
    kinds, sources, last_entry_s = Counter[str](), Counter[str](), 0.0
    for source, entry in read.lines:
        kinds[kind_of(entry.record)] += 1
        sources[source] += 1
        last_entry_s = max(last_entry_s, entry.t_s)
    return Summary(
        run=header.run,
        folder=str((run if run.is_dir() else run.parent).resolve()),
        scenario=header.scenario.get("name"),
        law=field_of(header.scenario, "law", "law"),
        robots=field_of(header.scenario, "fleet", "robots"),
        seed=header.seed,
        scenario_hash=header.scenario_hash,
        versions=header.versions,
        sim_s=None if verdict is None else verdict.sim_s,
        last_entry_s=last_entry_s,
        ended=read.ended,
        verdict=None if verdict is None else _judged(verdict),
        entries=kinds.total(),
        sources=dict(sorted(sources.items())),
        kinds=dict(sorted(kinds.items())),
        flaws=(*read.flaws, *flaws),
    )


def field_of(scenario: dict[str, Any], section: str, key: str) -> Any:  # noqa: ANN401 - unchecked, as written
    """A field of a scenario, perhaps written by another version."""
    fields = scenario.get(section)
    return fields.get(key) if isinstance(fields, dict) else None


def verdict_beside(log: Path) -> tuple[Verdict | None, tuple[str, ...]]:
    """The verdict beside a log, and its flaws."""
    if log.name != EVENTS_FILE:  # a copy with another name may be of another run
        return None, ()
    try:
        return read_verdict(log.parent), ()
    except FileNotFoundError:
        return None, ()
    except OSError as error:  # the text of this error has its number and the whole path
        return None, (plain(f"{VERDICT_FILE} cannot be read: {error.strerror}"),)
    except msgspec.MsgspecError as error:
        return None, (plain(f"{VERDICT_FILE} cannot be read: {error}"),)


def _judged(verdict: Verdict) -> Judged:
    return Judged(ok=verdict.ok, exit_code=verdict.exit_code, reason=verdict.reason)
