"""Reads the folder of a run, or of several fleets, and has it judged a second time. A shell."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from clew.judge.agree import disagreements
from clew.judge.between import Between, judge_between
from clew.judge.between import disagreements as differences
from clew.judge.poses import Finding, judge
from clew.judge.truth import Run, Scene, UnreadableError, read_run, read_scene_file, scene_of
from protocol.errors import UsageError
from protocol.files.opening import MADE_BYTES_MAX, open_regular, read_bytes
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE


@dataclass(frozen=True, kw_only=True)
class Judged:
    """What was found of one fleet."""

    scene: Scene
    run: Run
    finding: Finding
    wrong: list[str] | None
    """In what the verdict differs; None: there is no verdict."""

    @property
    def ok(self) -> bool:
        """Whether the fleet kept its promises and arrived, and the verdict says nothing else."""
        return self.finding.ok and not self.wrong


def judged(run: Path, scene: Path | None) -> Judged:
    """Judge a run, given by its folder or its timeline; by its own scenario or by another file.

    Raises:
        UsageError: something in it cannot be read as what it should be.
        OSError: it cannot be read at all.
    """
    folder = run if run.is_dir() else run.parent
    try:
        with open_regular(run / EVENTS_FILE if run.is_dir() else run) as lines:
            read = read_run(lines)
        ground = scene_of(read, None if scene is None else read_scene_file(scene))
        finding = judge(ground, read)
        said = _verdict(folder)
        wrong = None if said is None else list(disagreements(finding, said))
        return Judged(scene=ground, run=read, finding=finding, wrong=wrong)
    except UnreadableError as error:
        raise UsageError(f"{run}: {error}") from error
    except KeyError as error:
        raise UsageError(f"{folder / VERDICT_FILE}: lacks {error}") from error


def judged_between(run: Path, fleets: Mapping[str, Judged]) -> tuple[Between, list[str] | None]:
    """Judge the fleets of a run against each other; also says in what the verdict on all differs.

    Raises:
        UsageError, OSError: as `judged`.
    """
    between = judge_between({name: (each.scene, each.run) for name, each in fleets.items()})
    try:
        said = _verdict(run)
        findings = {name: each.finding for name, each in fleets.items()}
        return between, None if said is None else list(differences(between, findings, said))
    except UnreadableError as error:
        raise UsageError(f"{run}: {error}") from error
    except KeyError as error:
        raise UsageError(f"{run / VERDICT_FILE}: lacks {error}") from error


def _verdict(folder: Path) -> dict[str, Any] | None:
    if not (folder / VERDICT_FILE).exists():
        return None
    try:
        said = json.loads(read_bytes(folder / VERDICT_FILE, MADE_BYTES_MAX))
    except ValueError as error:
        raise UnreadableError(f"{VERDICT_FILE}: {error}") from error
    if not isinstance(said, dict):
        raise UnreadableError(f"{VERDICT_FILE}: is no object")
    return said
