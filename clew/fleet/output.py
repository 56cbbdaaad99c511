"""The output of a fleet besides its verdict: the output of its parts, and the state of the terminal.

Rule 1: with a live table or with --quiet, the output of the parts goes to a file. It is printed at the end,
        except for the progress lines, which the table has shown.
Rule 2: the terminal is restored: a table that was killed has left the cursor hidden.
Rule 3: a closed terminal or pipe does not make a run fail. A result that cannot be written, because a disk is
        full for example, does.
"""

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path

import msgspec

from clew.fleet.parts.command_lines import SAID_FILE
from clew.fleet.prepare import Prepared, Shows
from clew.fleet.table_said import PROGRESS
from protocol.errors import UsageError
from protocol.plain import plain
from world.judge.together import TogetherVerdict
from world.judge.verdict import VERDICT_FILE, Verdict

STDOUT, STDERR = 1, 2
CLOSED = (errno.EPIPE, errno.EIO)  # a pipe without a reader; a terminal that was closed
SHOW_CURSOR = b"\x1b[?25h"
BEGIN_LINE = b"\x1b[0m\r\n\x1b[J"


class Output:
    """The destination of messages during a run."""

    def __init__(self, stderr: int) -> None:
        self.stderr = stderr
        """The stderr of the parts."""

    def say(self, text: str) -> None:
        """Print a line for the user, between the output of the parts."""
        _write(self.stderr, f"clew: {plain(text)}\n".encode())

    def mend_terminal(self) -> None:
        """Restore the cursor and begin a new line, after a table has died while drawing."""
        _write(STDERR, SHOW_CURSOR + BEGIN_LINE)


def say_start(run: Prepared) -> None:
    """Print what is being started: many robots take some seconds until their first entry."""
    if run.shows is not Shows.NOTHING:
        fleets = f" in {len(run.fleets)} fleets" if run.fleets else ""
        Output(STDERR).say(f"starting {run.robots} {'robot' if run.robots == 1 else 'robots'}{fleets}")


@contextlib.contextmanager
def output(run: Prepared) -> Iterator[Output]:
    """Send messages where this run wants them; at the end of the context, all of them are on stderr."""
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
    with said.open(encoding="utf-8", errors="replace", newline="\n") as lines:
        for line in lines:
            if not PROGRESS.match(line):
                yield f"{plain(line.rstrip())}\n".encode()


def say_result(run: Prepared, stand_in: Verdict | TogetherVerdict | None = None) -> bool:
    """Print the verdict; returns whether the run has one, or has left a log.

    Args:
        run: the run, which has ended.
        stand_in: the verdict by the launcher, if the world has not written one.

    Raises:
        OSError: it cannot be written (rule 3).
    """
    from clew.fleet import summary, together  # noqa: PLC0415 - not needed at the start of a run

    verdict, stderr = run.folder / VERDICT_FILE, Output(STDERR)
    if stand_in is not None:
        if run.as_json:
            _write_all(msgspec.json.format(msgspec.json.encode(stand_in)) + b"\n")
        stderr.say(f"FAILED: {stand_in.reason}. Run: {run.folder}")
    elif has_content(verdict):
        try:
            summary_of = together.summary_of if run.fleets else summary.summary_of
            text = verdict.read_text(encoding="utf-8") if run.as_json else summary_of(str(run.folder))
            _write_all(text.encode())
        except UsageError as error:
            stderr.say(str(error))
    else:
        return False
    return True


def has_content(path: Path) -> bool:
    """Whether a file exists and is not empty."""
    return path.exists() and path.stat().st_size > 0


def _write_all(text: bytes) -> None:
    try:
        with open(STDOUT, "wb", closefd=False) as stdout:
            stdout.write(text)
    except OSError as error:
        if error.errno not in CLOSED:
            raise


def _write(descriptor: int, text: bytes) -> None:
    with contextlib.suppress(OSError):
        os.write(descriptor, text)
