"""Errors by their cause: the user or a peer. Errors of our own are assertions."""

import traceback
from collections.abc import Collection
from itertools import dropwhile
from pathlib import Path

FRAMES_MAX = 8  # the last calls: enough to find the place
REASON_LENGTH_MAX = 2000  # the limit for texts in the timeline
UNREADABLE = (ValueError, RecursionError)
"""What any decoder raises for bytes: for wrong fields and for what is no UTF-8, and for deep nesting."""


class ClewError(Exception):
    """The base class of all exceptions that Clew raises on purpose."""


class UsageError(ClewError):
    """The user asked for something impossible: one clear line, exit code 2."""


class SessionLostError(ClewError):
    """This process's Zenoh session is lost. It can neither send nor receive, so the process ends."""


class MessageRefusedError(ClewError):
    """A peer's message breaks the protocol: it is counted, logged with its sender, and dropped."""


def no_run_in(run: Path) -> UsageError:
    """The refusal of a run's folder that does not exist."""
    return UsageError(f"no run in {run}: there is no such folder")


def recordable(text: str) -> str:
    """The text as a timeline can hold it: not too long, and without halves of characters (surrogates)."""
    return text[:REASON_LENGTH_MAX].encode(errors="backslashreplace").decode()[:REASON_LENGTH_MAX]


def is_failure(error: BaseException) -> bool:
    """Whether the code of a user has failed by this: it may be a panic of a library in Rust, too.

    That is no `Exception`, and its class cannot be imported. What interrupts the code is no failure of it.
    """
    by_name = type(error).__name__ in {"PanicException", "CancelledError"}
    return by_name or isinstance(error, Exception | SystemExit)


def sentence_of(error: BaseException, *, through: Collection[str] = ()) -> str:
    """What an error says: its message, and the last calls with file and line.

    Calls of the files `through`, which call the code of a user, are left out: the user's file may be called
    as one of them.
    """
    frames = dropwhile(lambda frame: frame.filename in through, traceback.extract_tb(error.__traceback__))
    calls = [f"{Path(frame.filename).name}:{frame.lineno} {frame.name}" for frame in frames]
    where = f" ({', '.join(calls[: -FRAMES_MAX - 1 : -1])})" if calls else ""
    return recordable(f"{type(error).__name__}: {_message_of(error)}{where}")


def _message_of(error: BaseException) -> str:
    try:
        return str(error)
    except Exception:  # it may be of a user's kind
        return "it cannot say why"
