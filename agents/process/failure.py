"""What is recorded of a core that has failed, which no core should."""

import traceback
from itertools import islice
from pathlib import Path

from protocol.timeline import RobotFailed

FRAMES_MAX = 8  # the last calls: enough to find the place
REASON_LENGTH_MAX = 2000  # what a text of the timeline may have


def failed(error: Exception) -> RobotFailed:
    """An exception as the timeline has it: what it says, and the last calls by file and line."""
    frames = reversed(traceback.extract_tb(error.__traceback__))
    calls = (
        f"{Path(frame.filename).name}:{frame.lineno} {frame.name}" for frame in islice(frames, FRAMES_MAX)
    )
    return RobotFailed(reason=f"{type(error).__name__}: {error} ({', '.join(calls)})"[:REASON_LENGTH_MAX])
