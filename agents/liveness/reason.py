"""Why a robot wants a view. Data."""

from dataclasses import dataclass

from protocol.fence import Cause


@dataclass(frozen=True, slots=True)
class Turnabout:
    """How the strand is to turn round, in arc lengths of the epoch that ends."""

    cut_m: float
    """Where the new path ends, as the leader knows it: the part before that is not needed any more.

    The path reaches at least to the place that the new leader reports. If that plans on its own, it ends
    there.
    """
    end_m: float
    """Where the new path begins: at the robot that leads until then."""
    back_by_m: float
    """How far the new tail wants to come back along the new path; 0: the new leader plans on its own."""


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a robot wants a view."""

    cause: Cause
    why: str
    about: int | None = None
    """The robot that is the reason, if one is."""
    how: str = ""
    """NEIGHBOUR_LOST: `token` or `silence`."""
    turnabout: Turnabout | None = None
    """DEAD_END: how the strand is to turn round."""
