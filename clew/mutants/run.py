"""Mutation testing: a campaign must catch each mutant of our source. A shell.

Rule 1: a mutant replaces an exact piece of source in a copy of the tree. A piece that does not occur, or
        occurs twice, is an error: the source has changed, and the mutant must follow.
Rule 2: the first seed that surprises with the mutant by what the mutant breaks, and does not surprise without
        it, catches it. One that the wall-clock limit has stopped catches nothing.
Rule 3: each mutant states within how many seeds it must be caught; or the test that catches it, which is then
        run in the copy instead.
Rule 4: the seed that caught a mutant the last time is played first, then the others from 1 on.
"""

import os
import resource
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeVar

import msgspec
from msgspec import Struct
from msgspec.structs import replace

from clew.campaign.campaign import drawn_episode
from clew.campaign.episode import Outcome, Surprise, play
from clew.mutants.mutant import Mutant
from clew.mutants.worker import WALL_S_MAX
from protocol.errors import UsageError
from protocol.exit_codes import ExitCode
from protocol.root import ROOT
from protocol.timeline.invariants import named

Told = TypeVar("Told")

PACKAGES = ("agents", "clew", "protocol", "world")
TESTS_FAILED = 1  # pytest's exit code
WORKER, GUIDED = "clew.mutants.worker", "guided"


class Caught(Struct, frozen=True, kw_only=True):
    """The result for one mutant."""

    mutant: str
    by: str | None
    """The broken invariants, or the kind of surprise; None: not caught."""
    seed: int | None
    seeds: int
    """How many seeds were played."""
    seeds_max: int
    cpu_s: float
    reason: str

    @property
    def ok(self) -> bool:
        """Whether it was caught within its seeds."""
        return self.by is not None


def run_mutant(mutant: Mutant) -> Caught:
    """Play seed after seed with the mutant, until one catches it or none is left.

    Raises:
        UsageError: the source does not contain the piece to replace, or contains it twice.
    """
    if mutant.check:
        return _checked(mutant)
    cpu_s, played = 0.0, 0
    with TemporaryDirectory(prefix="clew-mutant-") as folder:
        apply(mutant, Path(folder))
        firsts = [] if mutant.seed == 1 else [mutant.seed]
        parts = [*((each, each) for each in firsts), (1, mutant.seeds_max)]
        for outcome in chain.from_iterable(outcomes_in(Path(folder), *part) for part in parts):
            played, cpu_s = played + 1, cpu_s + outcome.cpu_s
            if is_catch(outcome, mutant) and passes_unmutated(outcome.seed):
                return Caught(
                    mutant=mutant.name,
                    by=by(outcome),
                    seed=outcome.seed,
                    seeds=played,
                    seeds_max=mutant.seeds_max,
                    cpu_s=cpu_s,
                    reason=outcome.reason,
                )
    return Caught(
        mutant=mutant.name,
        by=None,
        seed=None,
        seeds=played,
        seeds_max=mutant.seeds_max,
        cpu_s=cpu_s,
        reason="",
    )


def _checked(mutant: Mutant) -> Caught:
    """Run the mutant's test in a copy of the source.

    Raises:
        UsageError: the test does not run there.
    """
    with TemporaryDirectory(prefix="clew-mutant-") as name:
        folder, before = Path(name), _spent_s()
        apply(mutant, folder)
        for each in ROOT.iterdir():  # what tests read
            if not (folder / each.name).exists():
                (folder / each.name).symlink_to(each)
        command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", mutant.check]
        with started(command, folder) as process:
            told, _ = process.communicate()
    if process.returncode not in (ExitCode.OK, TESTS_FAILED):
        raise UsageError(f"mutant {mutant.name}: {mutant.check} does not run: {told.decode()[-200:]}")
    return Caught(
        mutant=mutant.name,
        by="test" if process.returncode == TESTS_FAILED else None,
        seed=None,
        seeds=0,
        seeds_max=0,
        cpu_s=_spent_s() - before,
        reason=mutant.check,
    )


def _spent_s() -> float:
    """CPU time of all processes that this one has waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def apply(mutant: Mutant, folder: Path) -> None:
    """Lay our source out in the folder, and put the mutated files there in place of ours.

    All else is links, with the bytecode: to copy and to compile it took more time than many a search. Folders
    without an edit are links as a whole: to make one for each file took as much time as to load them.

    Raises:
        UsageError: the source does not contain the piece to replace, or contains it twice.
    """
    for package in PACKAGES:
        (folder / package).symlink_to(ROOT / package)
    for edit in mutant.edits:
        path = folder / edit.file
        for each in (*reversed(Path(edit.file).parents[:-1]), Path(edit.file).parent / "__pycache__"):
            _divide(folder / each)
        text = path.read_text(encoding="utf-8")
        if (count := text.count(edit.before)) != 1:
            raise UsageError(
                f"mutant {mutant.name}: {edit.file} has {count} times, not once: {edit.before!r}"
            )
        for ours in (path, *path.parent.glob(f"__pycache__/{path.stem}.*")):
            ours.unlink()  # a link: to write there would change our source
        path.write_text(text.replace(edit.before, edit.after), encoding="utf-8")


def _divide(link: Path) -> None:
    """Put a folder of links in place of a link to a folder."""
    if link.is_symlink():
        ours = link.readlink()
        link.unlink()
        link.mkdir()
        for each in ours.iterdir():
            (link / each.name).symlink_to(each)


def is_catch(outcome: Outcome, mutant: Mutant) -> bool:
    """Whether the episode surprised by what the mutant breaks.

    The wall-clock limit says nothing: it may be the machine.
    """
    if outcome.surprise in {Surprise.NONE, Surprise.STOPPED}:
        return False
    broken = {each for each, count in outcome.violations_by_invariant.items() if count}
    return not {*broken, str(outcome.surprise)}.isdisjoint(mutant.breaks)


def passes_unmutated(seed: int) -> bool:
    """Whether the seed's episode does not surprise without a mutant."""
    episode = drawn_episode(seed, Path(), "", wall_s_max=WALL_S_MAX)
    return play(replace(episode, judged=True)).surprise is Surprise.NONE


def by(outcome: Outcome) -> str:
    """The broken invariants, or the kind of surprise."""
    broken = [named(each) for each, count in outcome.violations_by_invariant.items() if count]
    return ", ".join(broken) if broken else str(outcome.surprise)


def outcomes_in(folder: Path, first: int, last: int, *, guided: bool = False) -> Iterator[Outcome]:
    """The outcomes of these seeds with the source in the folder."""
    return told_in(folder, [WORKER, str(first), str(last), *([GUIDED] if guided else [])], Outcome)


def told_in(folder: Path, module: Sequence[str], kind: type[Told]) -> Iterator[Told]:
    """Run a module with its arguments, on the source in the folder; yields what each printed line says."""
    with started([sys.executable, "-m", *module], folder) as process:
        assert process.stdout is not None, "opened as a pipe"
        for line in process.stdout:
            yield msgspec.json.decode(line, type=kind)
        if process.wait() != 0:
            assert process.stderr is not None, "opened as a pipe"
            last_words = process.stderr.read().decode(errors="replace").strip().splitlines()[-1:]
            raise UsageError(f"the mutated source does not start: {' '.join(last_words)}")


@contextmanager
def started(command: Sequence[str], folder: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """A process with the source in a folder; it ends with the context."""
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
