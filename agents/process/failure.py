"""The timeline entry for a core that has failed, which should never happen."""

from protocol.errors import sentence_of
from protocol.timeline import RobotFailed


def failed(error: Exception) -> RobotFailed:
    """The entry for an exception: its message, and the last calls with file and line."""
    return RobotFailed(reason=sentence_of(error))
