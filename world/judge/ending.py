"""The reasons for the end of a run; docs/run.md."""

from enum import StrEnum

from protocol.exit_codes import ExitCode


class Ending(StrEnum):
    """The reason for the end of `running`."""

    ARRIVED = "every living robot has arrived"
    ROUTE_LOST = "no_route: the leader knows no way on"
    STRANDED = "no robot can go on: those that have not arrived are stranded"
    STUCK = "nothing moves any more"
    EXTINCT = "every robot has died"
    TIMED_OUT = "the time is up"
    MISSING = "not all robots came"
    CUT_OFF = "the router was lost"
    INTERRUPTED = "interrupted"
    TERMINATED = "told to end"
    HUNG_UP = "its terminal was closed"
    LOST_PROCESS = "another process of the run was lost"


ASKED = {
    ExitCode.INTERRUPTED: Ending.INTERRUPTED,
    ExitCode.TERMINATED: Ending.TERMINATED,
    ExitCode.HUNG_UP: Ending.HUNG_UP,
    ExitCode.FAILED: Ending.LOST_PROCESS,
}
"""The endings that a run is asked for, by the exit code of the request."""
