"""What a search tries: which rules hold, what may happen, and which reductions are sound there."""

from collections.abc import Callable, Collection
from typing import NamedTuple

from tests.model.properties import Property
from tests.model.rules import Rule
from tests.model.values import REGISTER_NUMBER

# While these hold, a message or memory of an older epoch, and an order of another turn, can move no body.
FORGETTING_RESTS_ON = frozenset(
    {
        Rule.EXACT_EPOCH,
        Rule.EXACT_TURN,
        Rule.NEXT_TURN_ONLY,
        Rule.PLACE_OF_THIS_EPOCH,
        Rule.WRITTEN_FIRST,
        Rule.STOP_AT_CHANGE,
    }
)
# A scan that these rules refuse for ever may be forgotten.
SCAN_FORGETTING_RESTS_ON = frozenset({Rule.SCAN_OF_THIS_EPOCH, Rule.SCAN_OF_THIS_TURN})


class Bounds(NamedTuple):
    """What may happen in a search, and how often."""

    robots: int = 2
    raises: int = 1
    faults: int = 0  # restarts of robots ("r") or of the world ("w")
    restarts: str = "rw"
    turns: int = 2  # before all, in each epoch
    nobody_turns: bool = True  # a coordinator may put turns that name nobody
    orders: int = 1  # in each turn
    late: int = 0  # odometries that arrive late
    stops: int = 0  # by the operator
    brake: bool = False  # bodies take time to stop
    raisers: tuple[int, ...] = (0,)
    early: bool = False  # robots scan at any time, not only when they may drive
    tail: bool = False  # the coordinator is the last of its formation, not the leader
    world: int = REGISTER_NUMBER  # the number in the epoch that a resumed world takes
    depth: int = 99


class Setting:
    """The rules that hold, the bounds, and the properties that are asked for."""

    def __init__(
        self, rules: Collection[Rule], bounds: Bounds, asked: Collection[Property] = frozenset(Property)
    ) -> None:
        self.asked = asked
        self.rules = frozenset(rules)
        self.on: Callable[[Rule], bool] = self.rules.__contains__
        self.bounds = bounds
        self.forgets = self.rules >= FORGETTING_RESTS_ON
        self.forgets_scans = self.rules >= SCAN_FORGETTING_RESTS_ON
