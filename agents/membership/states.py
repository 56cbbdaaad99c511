"""The four states of a robot in a view. Data."""

from enum import StrEnum


class State(StrEnum):
    """What a robot does in the view whose epoch its odometry tells."""

    BOUND = "bound"  # it stands, and reports to the coordinator
    JOINING = "joining"  # it has the turn: it drives to its place by its own steps
    MEMBER = "member"  # it leads or follows in the strand
    ASIDE = "aside"  # it is left out: it stands, and asks the leader to be let in
