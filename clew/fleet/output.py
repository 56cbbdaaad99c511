"""What the user sees of a fleet beside its verdict: what its parts say, and the terminal.

Rule 1: while there is a table, or nothing, what the parts say goes into a file. It comes out at the end, but
        for the progress, which the table has shown.
Rule 2: the terminal is left as it was: a table that was killed has not shown the cursor again.
Rule 3: a run does not fail because nobody listens: a terminal may go, and a pipe may close.
"""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from clew.fleet.parts.command_lines import SAID_FILE
from clew.fleet.prepare import Prepared, Shows
from clew.fleet.table_said import PROGRESS
from protocol.errors import UsageError
from protocol.plain import plain
from world.judge.verdict import VERDICT_FILE
from world.record.recorder import EVENTS_FILE

STDOUT, STDERR = 1, 2
SHOW_CURSOR = b"\x1b[?25h"
BEGIN_LINE = b"\x1b[0m\r\n\x1b[J"


class Output:
    """Where words go while a run goes on."""

    def __init__(self, stderr: int) -> None:
        self.stderr = stderr
        """For the parts."""

    def say(self, text: str) -> None:
        """Tell the user in a line, among what the parts say."""
        _write(self.stderr, f"clew: {plain(text)}\n".encode())

    def mend_terminal(self) -> None:
        """A table has died in the middle of a picture: what is said next has a line of its own."""
        _write(STDERR, SHOW_CURSOR + BEGIN_LINE)


@contextlib.contextmanager
def output(run: Prepared) -> Iterator[Output]:
    """While the context lasts, words go where this run wants them; then all of them are on stderr."""
    if run.shows is Shows.LINES:
        yield Output(STDERR)
        return
    said = run.private / SAID_FILE
    descriptor = os.open(said, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
    try:
        yield Output(descriptor)
    finally:
        os.close(descriptor)
        if run.shows is Shows.TABLE:
            _write(STDERR, SHOW_CURSOR)
        _write(STDERR, b"".join(_words(said)))


def _words(said: Path) -> Iterator[bytes]:
    progress = tuple(each.encode() for each in PROGRESS)
    with said.open("rb") as lines:
        for line in lines:
            if not line.startswith(progress):
                yield f"{plain(line.decode(errors='replace').rstrip())}\n".encode()


def say_result(run: Prepared) -> bool:
    """Print the verdict, or say that there is none; returns whether the run has left anything."""
    from clew.fleet.summary import summary_of  # noqa: PLC0415 - a run that begins does not wait for it

    verdict, stderr = run.folder / VERDICT_FILE, Output(STDERR)
    if has_content(verdict):
        try:
            text = verdict.read_text(encoding="utf-8") if run.as_json else summary_of(str(run.folder))
            _write_all(text.encode())
        except UsageError as error:
            stderr.say(str(error))
    elif has_content(run.folder / EVENTS_FILE):
        stderr.say(f"no verdict was written; what happened until then is in {run.folder}")
    else:
        return False
    return True


def has_content(path: Path) -> bool:
    """Whether a file is there, and not empty."""
    return path.exists() and path.stat().st_size > 0


def _write_all(text: bytes) -> None:
    with contextlib.suppress(OSError), open(STDOUT, "wb", closefd=False) as stdout:
        stdout.write(text)


def _write(descriptor: int, text: bytes) -> None:
    with contextlib.suppress(OSError):
        os.write(descriptor, text)
