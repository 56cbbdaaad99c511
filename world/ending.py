"""Why a run is over; docs/run.md."""

from enum import StrEnum


class Ending(StrEnum):
    """The end of `running`."""

    ARRIVED = "every robot has arrived"
    ROUTE_LOST = "no_route: the leader knows no way on"
    DEATH = "a robot died and nothing moves any more"
    TIMED_OUT = "the time is up"
    MISSING = "not all robots came"
    CUT_OFF = "the router was lost"
    INTERRUPTED = "interrupted"
    TERMINATED = "told to end"
