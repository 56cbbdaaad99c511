"""The phases of a view, as its coordinator sees them. Data."""

from enum import StrEnum
from types import MappingProxyType


class Phase(StrEnum):
    """What the coordinator waits for."""

    GATHERING = "gathering"  # reports
    LOOKING = "looking"  # what robots see of their legs, or of the nearest obstacle
    TURNING = "turning"  # the end of a turn
    CLOSING = "closing"  # places that are newer than all turns, and the newest map
    FORMED = "formed"  # nothing: the formation is made


PHASES = MappingProxyType(
    {
        Phase.GATHERING: frozenset({Phase.LOOKING, Phase.CLOSING}),
        Phase.LOOKING: frozenset({Phase.TURNING, Phase.GATHERING}),
        Phase.TURNING: frozenset({Phase.CLOSING, Phase.GATHERING}),
        Phase.CLOSING: frozenset({Phase.FORMED, Phase.GATHERING}),
        Phase.FORMED: frozenset[Phase](),
    }
)
"""Which phases may follow which."""
