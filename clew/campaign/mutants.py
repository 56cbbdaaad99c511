"""The oracle check: bugs planted on purpose, each of which a campaign has to catch. A shell.

Rule 1: a bug is an exact piece of source that is replaced in a copy of the tree. A piece that is not there,
        or there twice, is an error: the source has moved on, and the bug has to follow.
Rule 2: a bug is caught by the first seed that surprises with it and does not without it.
Rule 3: each bug says within how many seeds that has to be.
"""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec
from msgspec import Struct

from clew.campaign.campaign import PACKAGES, drawn_episode
from clew.campaign.episode import Outcome, Surprise, play
from clew.campaign.mutants_list import Bug
from clew.campaign.mutants_worker import WALL_S_MAX
from protocol.errors import UsageError
from protocol.root import ROOT


class Caught(Struct, frozen=True, kw_only=True):
    """What came of a bug."""

    bug: str
    by: str | None
    """Which invariant, or what else surprised; None: nothing did."""
    seed: int | None
    seeds: int
    """How many were played."""
    seeds_max: int
    cpu_s: float
    reason: str

    @property
    def ok(self) -> bool:
        """Whether it was caught in time."""
        return self.by is not None


def hunt(bug: Bug, first_seed: int = 1) -> Caught:
    """Play seed after seed with the bug, until one catches it or its seeds are used up.

    Raises:
        UsageError: the piece of source that it replaces is not there.
    """
    cpu_s, played = 0.0, 0
    with TemporaryDirectory(prefix="clew-oracle-") as folder:
        plant(bug, Path(folder))
        for outcome in _outcomes(Path(folder), first_seed, first_seed + bug.seeds_max - 1):
            played, cpu_s = played + 1, cpu_s + outcome.cpu_s
            if outcome.surprise is not Surprise.NONE and is_sound(outcome.seed):
                return Caught(
                    bug=bug.name,
                    by=_by(outcome),
                    seed=outcome.seed,
                    seeds=played,
                    seeds_max=bug.seeds_max,
                    cpu_s=cpu_s,
                    reason=outcome.reason,
                )
    return Caught(
        bug=bug.name,
        by=None,
        seed=None,
        seeds=played,
        seeds_max=bug.seeds_max,
        cpu_s=cpu_s,
        reason="",
    )


def plant(bug: Bug, folder: Path) -> None:
    """Copy our source there, with the bug in it.

    Raises:
        UsageError: the piece of source that it replaces is not there, or not once.
    """
    for package in PACKAGES:
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    for edit in bug.edits:
        path = folder / edit.file
        text = path.read_text(encoding="utf-8")
        if (count := text.count(edit.before)) != 1:
            raise UsageError(f"bug {bug.name}: {edit.file} has {count} times, not once: {edit.before!r}")
        path.write_text(text.replace(edit.before, edit.after), encoding="utf-8")


def is_sound(seed: int) -> bool:
    """Whether nothing surprises in the episode of a seed without any bug."""
    return play(drawn_episode(seed, Path(), "", wall_s_max=WALL_S_MAX)).surprise is Surprise.NONE


def _by(outcome: Outcome) -> str:
    broken = [name for name, count in outcome.violations_by_invariant.items() if count]
    return ", ".join(broken) if broken else str(outcome.surprise)


def _outcomes(folder: Path, first: int, last: int) -> Iterator[Outcome]:
    command = [sys.executable, "-m", "clew.campaign.mutants_worker", str(first), str(last)]
    with _started(command, folder) as process:
        assert process.stdout is not None, "it was asked for"
        for line in process.stdout:
            yield msgspec.json.decode(line, type=Outcome)
        if process.wait() != 0:
            assert process.stderr is not None, "it was asked for"
            last_words = process.stderr.read().decode(errors="replace").strip().splitlines()[-1:]
            raise UsageError(f"a tree with a bug in it does not even start: {' '.join(last_words)}")


@contextmanager
def _started(command: Sequence[str], folder: Path) -> Iterator["subprocess.Popen[bytes]"]:
    environment = {**os.environ, "PYTHONPATH": str(folder), "OPENBLAS_NUM_THREADS": "1"}
    process = subprocess.Popen(  # noqa: S603 - our own interpreter on our own module
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    try:
        with process:
            try:
                yield process
            finally:
                process.kill()
    finally:
        process.wait()
