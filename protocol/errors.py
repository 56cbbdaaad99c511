"""Errors by their cause: the user or a peer. Errors of our own are assertions."""

import traceback
from itertools import islice
from pathlib import Path

FRAMES_MAX = 8  # the last calls: enough to find the place
REASON_LENGTH_MAX = 2000  # the limit for texts in the timeline


class ClewError(Exception):
    """The base class of all exceptions that Clew raises on purpose."""


class UsageError(ClewError):
    """The user asked for something impossible: one clear line, exit code 2."""


class SessionLostError(ClewError):
    """This process's Zenoh session is lost. It can neither send nor receive, so the process ends."""


class MessageRefusedError(ClewError):
    """A peer's message breaks the protocol: it is counted, logged with its sender, and dropped."""


def sentence_of(error: Exception) -> str:
    """What an error of our own says: its message, and the last calls with file and line."""
    frames = reversed(traceback.extract_tb(error.__traceback__))
    calls = (
        f"{Path(frame.filename).name}:{frame.lineno} {frame.name}" for frame in islice(frames, FRAMES_MAX)
    )
    return f"{type(error).__name__}: {error} ({', '.join(calls)})"[:REASON_LENGTH_MAX]
