"""The runs in a folder: how each ended, its size and its age; and how they are deleted.

Rule 1: a run that goes on is never deleted. Its world can be reached, or it has no verdict and was written to
        in the last `QUIET_S`: a rehearsal has no world to reach, and a run that begins has none yet.
Rule 2: only the folder of a run is deleted: one that holds its settings or its timeline.
"""

import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TypeVar

import msgspec
from msgspec import Struct

from clew.fleet.folder import LATEST
from protocol.errors import UsageError
from protocol.faults.manual_faults import is_running
from protocol.files.opening import MADE_BYTES_MAX, read_bytes
from protocol.run_settings import SETTINGS_FILE

Part = TypeVar("Part")

VERDICT, EVENTS = "verdict.json", "events.jsonl"
QUIET_S = 60.0  # a world writes every 0.1 s; to start may take this long on a loaded machine


class Ended(Struct, frozen=True):
    """What a list says of a verdict."""

    ok: bool
    reason: str


class Listed(Struct, frozen=True, kw_only=True):
    """A run in a list."""

    run: str
    """Its folder."""
    verdict: Ended | None
    """None: there is none, or it cannot be read."""
    is_unreadable: bool
    """Whether there is a verdict that cannot be read."""
    goes_on: bool
    size_bytes: int
    age_s: float
    """Since it was last written to."""

    @property
    def said(self) -> str:
        """How it ended, in words."""
        if self.is_unreadable:
            return f"{VERDICT} cannot be read"
        if self.verdict is None:
            return "going on" if self.goes_on else "no verdict"
        return f"{'OK' if self.verdict.ok else 'FAILED'}: {self.verdict.reason}"


def is_run(folder: Path) -> bool:
    """Whether a folder is that of a run."""
    return folder.is_dir() and any((folder / name).is_file() for name in (SETTINGS_FILE, EVENTS))


def check_is_run(folder: Path) -> None:
    """Refuse what is no run.

    Raises:
        UsageError: it is none.
    """
    if not folder.exists():
        raise UsageError(f"{folder}: there is no such run")
    if not is_run(folder):
        raise UsageError(f"{folder}: is not the folder of a run")


def runs_in(folder: Path, now_s: float) -> list[Listed]:
    """All runs in a folder, the newest first; `now_s` is the time of the files' clock."""
    try:
        found = [path for path in folder.iterdir() if is_run(path) and not path.is_symlink()]
    except FileNotFoundError:
        return []
    return sorted((listed(path, now_s) for path in found), key=lambda each: each.age_s)


def listed(run: Path, now_s: float) -> Listed:
    """A run as it is in a list."""
    has_verdict = (run / VERDICT).exists()  # asked first: it may be written just now
    verdict = verdict_in(run, Ended)
    facts = [path.lstat() for path in (run, *run.rglob("*"))]
    age_s = now_s - max(each.st_mtime for each in facts)
    return Listed(
        run=str(run),
        verdict=verdict,
        is_unreadable=has_verdict and verdict is None,
        goes_on=is_running(run) or (verdict is None and not has_verdict and age_s < QUIET_S),
        size_bytes=sum(each.st_size for each in facts),
        age_s=max(age_s, 0.0),
    )


def verdict_in(run: Path, part: type[Part]) -> Part | None:
    """The part of a run's verdict with these fields; None: there is none, or it cannot be read."""
    try:
        return msgspec.json.decode(read_bytes(run / VERDICT, MADE_BYTES_MAX), type=part)
    except (OSError, msgspec.MsgspecError):
        return None


def deletable(folders: Sequence[Path], now_s: float) -> Iterator[Listed]:
    """These runs, each once.

    Raises:
        UsageError: one is no run, or goes on (rules 1 and 2).
    """
    for folder in dict.fromkeys(path.resolve() if path.is_symlink() else path for path in folders):
        check_is_run(folder)
        run = listed(folder, now_s)
        if run.goes_on:
            raise UsageError(f"{folder}: the run goes on, or was written to in the last {QUIET_S:g} s")
        yield run


def delete(run: Listed) -> None:
    """Delete a run, and the link to the newest run where it was that.

    Raises:
        UsageError: it cannot be deleted.
    """
    try:
        shutil.rmtree(run.run)
        if LATEST.is_symlink() and not LATEST.exists():
            LATEST.unlink()
    except OSError as error:
        raise UsageError(f"{run.run}: cannot be deleted: {error.strerror}") from error
