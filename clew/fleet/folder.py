"""The folder of a run: its name, how it is made, and the link `runs/latest` to the newest one."""

import contextlib
import re
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path

from protocol.errors import UsageError
from protocol.faults.plan_text import FAULTS_FILE
from protocol.files.writing import make_folder as make_private
from protocol.files.writing import open_private
from protocol.run_settings import SCENARIO_FILE, SETTINGS_FILE
from world.record.recorder import EVENTS_FILE

RUNS = Path("runs")
LATEST = RUNS / "latest"
MADE_NAME = r"\d{8}T\d{6}Z-.+"  # `folder_name` makes them; in the order of time, they are sorted
NAME_MAX = 60  # letters of a scenario's name: a line of `clew ls` has room for them


def folder_name(now: datetime, scenario: str, token: str) -> str:
    """The name of the run's folder in `runs/`, with the scenario's name, as a shell takes it."""
    name = re.sub(r"[^A-Za-z0-9_]+", "-", scenario)[:NAME_MAX].strip("-") or "scenario"
    return f"{now:%Y%m%dT%H%M%SZ}-{name}-{token}"


def make_folder(folder: Path) -> list[Path]:
    """Make the run's folder or use an empty one, and claim it; returns the new folders, deepest first.

    Raises:
        UsageError: it cannot be made or written to, or it is not empty.
    """
    missing: list[Path] = []
    try:
        missing = [path for path in (folder, *folder.parents) if not path.exists()]
        if missing:
            make_private(folder)
        if any(folder.iterdir()):
            raise UsageError(f"{folder}: is not empty; a run needs a new or an empty folder")
        _claim(folder)
    except OSError as error:
        for path in missing:
            with contextlib.suppress(OSError):
                path.rmdir()
        raise UsageError(f"cannot write a run into {folder}: {error.strerror or error}") from error
    return missing


def _claim(folder: Path) -> None:
    """Write the first file, exclusively: of two fleets that begin here at once, the other is refused."""
    try:
        open_private(folder / SETTINGS_FILE, "x").close()
    except FileExistsError as error:
        raise UsageError(f"{folder}: another fleet begins there") from error


def make_latest(folder: Path) -> None:
    """Link `runs/latest` to this folder in `runs/`, in one atomic step."""
    link = LATEST.with_name(f"{folder.name}.link")
    link.symlink_to(folder.name)
    link.replace(LATEST)


@contextlib.contextmanager
def new_folder(folder: Path, *, is_latest: bool) -> Iterator[None]:
    """Make the run's folder, and link it; a run that is refused before its timeline leaves neither.

    Raises:
        UsageError: as `make_folder`.
    """
    made = make_folder(folder)
    if is_latest:
        make_latest(folder)
    try:
        yield
    except UsageError:
        if not any(folder.rglob(EVENTS_FILE)):
            drop_folder(folder, made, LATEST if is_latest else None)
        raise


def drop_folder(folder: Path, made: Sequence[Path], latest: Path | None) -> None:
    """Remove the files, folders (deepest first) and link that were made for a run that never began."""
    with contextlib.suppress(OSError):  # it holds other files, so it stays, with the folders above it
        fleets = [path for path in folder.iterdir() if (path / SETTINGS_FILE).is_file()]
        for path in (*fleets, folder):
            laws = [each.name for each in path.glob("*.py")]  # it was empty, so they are ours
            for name in (SCENARIO_FILE, SETTINGS_FILE, FAULTS_FILE, *laws):
                (path / name).unlink(missing_ok=True)
        for path in (*fleets, *made[:1]):
            path.rmdir()
        if latest is not None and not latest.exists():
            _link_an_earlier(latest)
        for path in made[1:]:
            path.rmdir()


def _link_an_earlier(latest: Path) -> None:
    """Link `runs/latest` to the newest run that is left, or remove it."""
    earlier = sorted(
        each for each in latest.parent.iterdir() if re.fullmatch(MADE_NAME, each.name) and each.is_dir()
    )
    if earlier:
        make_latest(earlier[-1])
    else:
        latest.unlink(missing_ok=True)
