"""Reads the folder of a run, or of several fleets, and has it judged a second time. A shell."""

import json
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

from clew.judge.agree import differences, disagreements
from clew.judge.poses import Finding, Least, judge, judge_between
from clew.judge.truth import SceneError, Truth, UnreadableError, read
from protocol.errors import UNREADABLE, UsageError
from protocol.files.opening import MADE_BYTES_MAX, open_regular, read_bytes
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE
from world.scenario.reading import find


@dataclass(frozen=True, kw_only=True)
class Judged:
    """What was found of one fleet."""

    truth: Truth
    finding: Finding
    wrong: list[str] | None
    """In what the verdict differs; None: there is no verdict."""

    @property
    def ok(self) -> bool:
        """Whether the fleet kept its promises and arrived, and the verdict says nothing else."""
        return self.finding.ok and not self.wrong

    def said(self) -> dict[str, Any]:
        """As `--json` says it."""
        return {"ok": self.ok, **asdict(self.finding), "disagreements": self.wrong}


def judged(run: Path, scene: Path | None) -> Judged:
    """Judge a run, given by its folder or its timeline; by its own scenario or by another file.

    Raises:
        UsageError: something in it cannot be read as what it should be.
        OSError: it cannot be read at all.
    """
    folder, events = (run, run / EVENTS_FILE) if run.is_dir() else (run.parent, run)
    try:
        with open_regular(events) as lines:
            truth = read(lines, None if scene is None else _content(find(str(scene))))
    except SceneError as error:
        raise UsageError(f"{scene}: {error}") from error
    except UnreadableError as error:
        raise UsageError(f"{run}: {error}") from error
    finding = judge(truth)
    return Judged(truth=truth, finding=finding, wrong=_wrong(folder, partial(disagreements, finding)))


def judged_between(run: Path, fleets: Mapping[str, Judged]) -> tuple[list[Least], list[str] | None]:
    """Judge the fleets of a run against each other; also says in what the verdict on all differs.

    Raises:
        UsageError, OSError: as `judged`.
    """
    near = judge_between({name: each.truth for name, each in fleets.items()})
    findings = {name: each.finding for name, each in fleets.items()}
    return near, _wrong(run, partial(differences, near, findings))


def _wrong(folder: Path, compare: Callable[[dict[str, Any]], Iterable[str]]) -> list[str] | None:
    path = folder / VERDICT_FILE
    if not path.exists():
        return None
    try:
        return list(compare(_content(path)))
    except (AttributeError, KeyError, TypeError) as error:
        raise UsageError(f"{path}: is no verdict: {type(error).__name__}: {error}") from error


def _content(path: Path) -> Any:  # noqa: ANN401 - what it should be is for its reader to ask
    try:
        text = read_bytes(path, MADE_BYTES_MAX).decode()
        return tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
    except UNREADABLE as error:
        raise UsageError(f"{path}: {error}") from error
