"""The exit codes of our processes."""

from enum import IntEnum


class ExitCode(IntEnum):
    """The last three follow the shells' rule: 128 + SIGHUP, 128 + SIGINT and 128 + SIGTERM."""

    OK = 0
    FAILED = 1
    USAGE = 2
    HUNG_UP = 129
    INTERRUPTED = 130
    TERMINATED = 143
