"""The timeline entry for a core that has failed, which should never happen."""

import traceback
from itertools import islice
from pathlib import Path

from protocol.timeline import RobotFailed

FRAMES_MAX = 8  # the last calls: enough to find the place
REASON_LENGTH_MAX = 2000  # the limit for texts in the timeline


def failed(error: Exception) -> RobotFailed:
    """The entry for an exception: its message, and the last calls with file and line."""
    frames = reversed(traceback.extract_tb(error.__traceback__))
    calls = (
        f"{Path(frame.filename).name}:{frame.lineno} {frame.name}" for frame in islice(frames, FRAMES_MAX)
    )
    return RobotFailed(reason=f"{type(error).__name__}: {error} ({', '.join(calls)})"[:REASON_LENGTH_MAX])
