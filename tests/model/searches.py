"""The searches: those that are clean with all rules, and the smallest sets of rules without which they break.

A set of several rules is one in which each covers the others: with any one of them back the search is clean.
"""

from typing import NamedTuple

from tests.model.properties import Property
from tests.model.rules import Rule
from tests.model.setting import Bounds

TURN = Bounds(turns=1)  # one turn, so that a robot that has driven in it is not yet in a formation
LEASE = Bounds()  # two turns: a robot drives in one, and the next names nobody
ROBOT_RESTARTS = TURN._replace(faults=1, restarts="r")
WORLD_RESTARTS = TURN._replace(faults=1, restarts="w")
TWO_RAISES = TURN._replace(raises=2)
LATE = TURN._replace(late=1)
BRAKES = LEASE._replace(brake=True)
EARLY = LEASE._replace(early=True)
TAIL = LEASE._replace(tail=True)
NO_TURN = Bounds(turns=0)
STOPS = NO_TURN._replace(stops=2)
STOP_AND_RESTART = NO_TURN._replace(stops=1, faults=1, restarts="w")


class Clean(NamedTuple):
    """A search that breaks nothing with all rules, and how many states it has when it closes."""

    name: str
    bounds: Bounds
    states: int = 0  # 0: never closed


class Without(NamedTuple):
    """Rules left out together, a property that breaks, and the length of its shortest traces."""

    rules: frozenset[Rule]
    bounds: Bounds
    broken: Property
    depth: int


def without(bounds: Bounds, broken: Property, depth: int, *rules: Rule) -> Without:
    """An entry of the table below."""
    return Without(frozenset(rules), bounds, broken, depth)


RESTART_OF_EITHER = TURN._replace(faults=1)
THREE = Bounds(robots=3)

SHORT = (
    Clean("one lease", LEASE, 8_058),
    Clean("the coordinator follows", TAIL, 7_379),
    Clean("bodies brake", BRAKES, 9_932),
    Clean("robots scan at any time", EARLY, 21_247),
    Clean("two raises by two robots", TWO_RAISES._replace(raisers=(0, 1)), 3_941),
    Clean("a robot restarts", ROBOT_RESTARTS, 8_900),
    Clean("the world restarts", LEASE._replace(faults=1, restarts="w"), 23_888),
    Clean("an odometry is late", LATE, 3_834),
    Clean("the operator stops twice", STOPS, 826),
    Clean("a stop, and the world restarts", STOP_AND_RESTART, 738),
    Clean("a stop around a lease", LEASE._replace(stops=1), 24_619),
    Clean("three robots, a restart", NO_TURN._replace(robots=3, faults=1), 24_674),
)
LONG = (
    Clean("three raises, bodies brake", TWO_RAISES._replace(raises=3, raisers=(0, 1), brake=True), 27_305),
    Clean("a robot restarts, bodies brake", ROBOT_RESTARTS._replace(brake=True, early=True), 47_083),
    Clean("three robots, one turn", THREE._replace(turns=1), 52_832),
    Clean("two raises around leases", LEASE._replace(raises=2, raisers=(0, 1)), 80_840),
    Clean("an odometry is late in a lease", LEASE._replace(late=1), 100_514),
    Clean("two restarts", TURN._replace(faults=2), 130_930),
    Clean("two raises and a restart", RESTART_OF_EITHER._replace(raises=2, raisers=(0, 1)), 109_776),
    Clean("a late odometry and a restart", RESTART_OF_EITHER._replace(late=1), 109_142),
    Clean("a lease and a restart", LEASE._replace(faults=1), 178_282),
    Clean(
        "two raises, a restart, a stop",
        RESTART_OF_EITHER._replace(raises=2, raisers=(0, 1), stops=1),
        327_254,
    ),
    Clean("three robots, one turn, a restart", THREE._replace(turns=1, faults=1)),
    Clean("three robots, one lease", THREE),
    Clean("two leases", LEASE._replace(turns=3), 96_121),
)

# Rules without which nothing breaks here, alone or with others left out, and why they are rules.
NOT_SHOWN = {
    Rule.TIE_AT_TURN_0: "liveness: without it a late raise of the same generation may end a view that moves",
    Rule.LINK_OF_THE_LIFE: "FORMATION_NAMES_LIVES covers it: a life that is not named tells no link state",
}

R, P = Rule, Property
BROKEN = (
    without(NO_TURN._replace(raises=2), P.ONE_FORMATION, 23, R.EXACT_EPOCH),
    without(LEASE, P.PLACES_TRUE, 21, R.EXACT_TURN),
    without(TAIL, P.NAMED_MOVES, 10, R.NAMED_ROBOT, R.ACTS_UNDER_ALL, R.FORMATION_NAMES_TURN),
    without(NO_TURN._replace(raises=2), P.PLACES_TRUE, 23, R.STOP_AT_CHANGE),
    without(ROBOT_RESTARTS._replace(tail=True), P.PLACES_TRUE, 24, R.LIFE_IN_TURN, R.PLACE_OF_A_LATER_TURN),
    without(BRAKES, P.ONE_FENCE, 17, R.ORDERS_IN_FORCE, R.SCAN_IN_FORCE),
    without(TURN, P.NAMED_MOVES, 13, R.ONE_NAMED),
    without(WORLD_RESTARTS._replace(turns=0), P.ONE_FORMATION, 20, R.ONE_FORMATION),
    without(TURN, P.PLACES_TRUE, 19, R.ALL_AFTER_FORMATION, R.FORMATION_NAMES_TURN),
    without(TURN, P.PLACES_TRUE, 19, R.NEXT_PUT_WHEN_TOLD, R.PUT_COUNTS_AT_ONCE, R.FORMATION_NAMES_TURN),
    without(TURN, P.PLACES_TRUE, 21, R.NOTHING_AFTER_ALL, R.ALL_IS_LAST),
    without(TWO_RAISES, P.PLACES_TRUE, 33, R.PLACE_OF_THIS_EPOCH),
    without(TURN, P.PLACES_TRUE, 18, R.PLACE_AFTER_OWN_TURN, R.PLACE_OF_A_LATER_TURN),
    without(
        TURN._replace(tail=True),
        P.PLACES_TRUE,
        19,
        R.PLACE_AFTER_OWN_TURN,
        R.PLACE_OF_A_LATER_TURN,
        R.MISFIT_STANDS,
    ),
    without(BRAKES, P.PLACES_TRUE, 22, R.PLACE_STANDING),
    without(TURN, P.PLACES_TRUE, 20, R.PLACE_ORDERS_ENDED, R.PLACE_OF_A_LATER_TURN),
    without(ROBOT_RESTARTS, P.PLACES_TRUE, 21, R.NEW_LIFE_STANDS, R.PLACE_OF_A_LATER_TURN),
    without(ROBOT_RESTARTS._replace(turns=0, tail=True), P.PLACES_TRUE, 19, R.FORMATION_NAMES_LIVES),
    without(TURN, P.GROUND_LEFT, 15, R.MOVES_BY_AUTHORITY),
    without(NO_TURN._replace(raises=2), P.SCAN_TRUE, 29, R.SCAN_OF_THIS_EPOCH),
    without(EARLY, P.SCAN_TRUE, 17, R.SCAN_OF_THIS_TURN),
    without(EARLY, P.SCAN_TRUE, 17, R.TURN_0_SCAN_ONLY_FOR_TURN_1),
    without(BRAKES, P.SCAN_TRUE, 19, R.SCAN_IN_FORCE),
    without(ROBOT_RESTARTS._replace(turns=0, tail=True), P.ONE_FORMATION, 26, R.EPOCH_NAMES_LIFE),
    without(LEASE, P.SCAN_TRUE, 18, R.NEXT_TURN_ONLY),
    without(WORLD_RESTARTS._replace(turns=0), P.PLACES_TRUE, 13, R.RESUMED_WORLD_RAISES),
    without(STOP_AND_RESTART, P.STOP_HOLDS, 13, R.WRITTEN_FIRST),
    without(LATE._replace(tail=True), P.PLACES_TRUE, 23, R.ODOMETRY_NUMBERED, R.PLACE_OF_A_LATER_TURN),
    without(STOPS, P.STOP_HOLDS, 12, R.STOPPED_REFUSES_RAISES),
    without(STOP_AND_RESTART, P.STOP_HOLDS, 14, R.STOPPED_SURVIVES_RESTART),
    without(STOPS, P.STOP_HOLDS, 16, R.RELEASE_NAMES_ITS_STOP),
)
