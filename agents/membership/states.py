"""The four states of a robot in a view, and the table of changes between them. Data."""

from enum import StrEnum
from types import MappingProxyType


class State(StrEnum):
    """What a robot does in the view whose epoch its odometry tells."""

    BOUND = "bound"  # it stands, and reports to the coordinator
    JOINING = "joining"  # it has the turn: it drives to its place by its own steps
    MEMBER = "member"  # it leads or follows in the strand
    ASIDE = "aside"  # it is left out: it stands, and asks the leader to be let in


class Happening(StrEnum):
    """What can change the state."""

    NEWER_EPOCH = "newer_epoch"  # the fence is of a newer epoch
    NAMED = "named"  # the fence names this robot and its life
    NEWER_FENCE = "newer_fence"  # the fence is newer: it ends the turn before, also where the next is its own
    FORMED = "formed"  # the fence is ALL, and this robot has its formation
    LEFT_OUT = "left_out"  # the coordinator says that it is not in the formation


TRANSITIONS: MappingProxyType[tuple[State, Happening], State] = MappingProxyType(
    {
        **{(state, Happening.NEWER_EPOCH): State.BOUND for state in State},
        (State.BOUND, Happening.NAMED): State.JOINING,
        (State.BOUND, Happening.FORMED): State.MEMBER,
        (State.BOUND, Happening.LEFT_OUT): State.ASIDE,
        (State.JOINING, Happening.NEWER_FENCE): State.BOUND,
    }
)
"""What is not in the table changes nothing."""


def after(state: State, happening: Happening) -> State:
    """The state after something has happened."""
    return TRANSITIONS.get((state, happening), state)
