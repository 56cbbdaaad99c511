"""How our processes end, for scripts to read."""

from enum import IntEnum


class ExitCode(IntEnum):
    """Shells know the last three as 128 + SIGHUP, 128 + SIGINT and 128 + SIGTERM."""

    OK = 0
    FAILED = 1
    USAGE = 2
    HUNG_UP = 129
    INTERRUPTED = 130
    TERMINATED = 143
