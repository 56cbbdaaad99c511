"""The rules of views and fences: one sentence each, and which of F1-F6 of the design it belongs to."""

from enum import StrEnum


class Rule(StrEnum):
    """One rule; a search may leave any of them out. `family` is what the design files it under.

    F1-F6 are the rules of the fence. REGISTER is the rest of 4.3: what the register takes and tells.
    """

    family: str

    def __new__(cls, family: str, sentence: str) -> "Rule":
        """A rule is its sentence, so that it hashes as fast as a string."""
        rule = str.__new__(cls, sentence)
        rule._value_, rule.family = sentence, family
        return rule

    EXACT_EPOCH = (
        "F1",
        "A body moves only by an order that bears its fence's epoch: no order of an old view drives.",
    )
    EXACT_TURN = (
        "F1",
        "A body moves only by an order that bears its fence's turn: no order of an old turn drives.",
    )
    NAMED_ROBOT = (
        "F1",
        "A body moves only if the fence names its robot or all: no robot drives in another's turn.",
    )
    STOP_AT_CHANGE = (
        "F1",
        "A body stops and drops its order when the fence changes: nothing moves under an old fence.",
    )
    LIFE_IN_TURN = (
        "F1",
        "A turn names the life that reported: the next life does not drive from a place reported over.",
    )

    ORDERS_IN_FORCE = (
        "F2",
        "A robot orders motion only under a fence in force: nobody drives while others still brake.",
    )

    ONE_NAMED = (
        "F3",
        "Before all, a fence names at most one robot: no two robots drive beside each other by turns.",
    )

    ONE_FORMATION = "F4", "An epoch has one formation, made once: no two contents of it move bodies."
    FORMATION_NAMES_TURN = (
        "F4",
        "A formation names the turn of its all: under another turn nobody acts on it.",
    )
    ALL_AFTER_FORMATION = (
        "F4",
        "After the formation the coordinator puts nothing but all: nobody leaves its place in it.",
    )
    NEXT_PUT_WHEN_TOLD = (
        "F4",
        "The coordinator puts the next turn when odometry told the last: no forgotten put is open.",
    )
    PUT_COUNTS_AT_ONCE = (
        "F4",
        "A robot's last turn is the last put for it, taken or not: one that is held up changes no place.",
    )
    NOTHING_AFTER_ALL = (
        "F4",
        "After all the coordinator puts nothing more: no turn moves a robot out of the formation.",
    )
    PLACE_OF_THIS_EPOCH = (
        "F4",
        "A place was reported under this epoch: no motion of an older view has changed it.",
    )
    PLACE_AFTER_OWN_TURN = (
        "F4",
        "A place was not reported before the last turn put for the robot: no turn has changed it.",
    )
    PLACE_OF_A_LATER_TURN = (
        "F4",
        "A place bears a later turn than the last put for the robot: that can change it no more.",
    )
    PLACE_STANDING = "F4", "A place was read while the body stood: the body is not still on its way."
    PLACE_ORDERS_ENDED = (
        "F4",
        "A turn is reported over when the newest order has ended: none is still to come.",
    )
    NEW_LIFE_STANDS = (
        "F4",
        "A new life first orders its body to stand: no order of the old life is still to come.",
    )
    FORMATION_NAMES_LIVES = (
        "F4",
        "A formation names lives: a life that does not know what was driven does not act on it.",
    )
    ACTS_UNDER_ALL = "F4", "A member acts on the formation only under all: nobody drives in another's turn."
    MISFIT_STANDS = "F4", "A member that stands elsewhere than the formation says does not act on it."

    MOVES_BY_AUTHORITY = (
        "F5",
        "A follower moves only by authority: it enters only ground that the robot ahead has left.",
    )
    LINK_OF_THE_LIFE = (
        "F5",
        "A link state counts only from the life that the formation names: no two plans are mixed.",
    )

    SCAN_OF_THIS_EPOCH = "F6", "No motion rests on a scan of another epoch: bodies moved since."
    SCAN_OF_THIS_TURN = "F6", "No motion rests on a scan of another turn: a body may have moved in between."
    TURN_0_SCAN_ONLY_FOR_TURN_1 = (
        "F6",
        "A scan of turn 0 serves under turn 1 at most: nobody has had a turn since.",
    )
    SCAN_IN_FORCE = (
        "F6",
        "No motion rests on a scan taken before the fence was in force: bodies still braked.",
    )

    EPOCH_NAMES_LIFE = (
        "REGISTER",
        "The epoch names the proposer's life, which alone coordinates: its next life knows nothing.",
    )
    TIE_AT_TURN_0 = (
        "REGISTER",
        "Within a generation a higher number wins at turn 0 only: a view that moves goes on (liveness).",
    )
    NEXT_TURN_ONLY = "REGISTER", "The register takes exactly the next turn: a late put changes nothing."
    ALL_IS_LAST = (
        "REGISTER",
        "The register takes no turn after all: no turn moves a robot out of the formation.",
    )
    RESUMED_WORLD_RAISES = (
        "REGISTER",
        "A resumed world raises first: it knows no order numbers, so no old order may fit.",
    )
    WRITTEN_FIRST = (
        "REGISTER",
        "A fence is written before it takes effect: a resumed world never goes back behind it.",
    )
    ODOMETRY_NUMBERED = (
        "REGISTER",
        "Odometry is numbered and the newest counts: no old place goes into a formation.",
    )
    STOPPED_REFUSES_RAISES = (
        "REGISTER",
        "Over stopped every raise is refused: robots cannot end an emergency stop.",
    )
    STOPPED_SURVIVES_RESTART = (
        "REGISTER",
        "A world resumed over stopped stays stopped: a crash does not end an emergency stop.",
    )
    RELEASE_NAMES_ITS_STOP = (
        "REGISTER",
        "A release is taken while exactly its generation is stopped: a late one ends no later stop.",
    )


DESIGN = frozenset(Rule)

# Which schedules of views.md, the companion page of the design, a rule answers. V3, V9, V10, V13 and V21
# to V23 are about geometry or liveness, which this model leaves out.
SCHEDULES: dict[Rule, tuple[str, ...]] = {
    Rule.EXACT_EPOCH: ("V6", "V14"),
    Rule.EXACT_TURN: ("V5", "V6"),
    Rule.NAMED_ROBOT: ("V6",),
    Rule.STOP_AT_CHANGE: ("V7",),
    Rule.LIFE_IN_TURN: ("V17", "V20"),
    Rule.ONE_FORMATION: ("V1",),
    Rule.FORMATION_NAMES_TURN: ("V19",),
    Rule.ALL_AFTER_FORMATION: ("V19",),
    Rule.NEXT_PUT_WHEN_TOLD: ("V19",),
    Rule.PUT_COUNTS_AT_ONCE: ("V19",),
    Rule.PLACE_OF_THIS_EPOCH: ("V14",),
    Rule.PLACE_AFTER_OWN_TURN: ("V5", "V16"),
    Rule.PLACE_OF_A_LATER_TURN: ("V20",),
    Rule.PLACE_STANDING: ("V5",),
    Rule.PLACE_ORDERS_ENDED: ("V5", "V16"),
    Rule.FORMATION_NAMES_LIVES: ("V2",),
    Rule.MISFIT_STANDS: ("V12",),
    Rule.LINK_OF_THE_LIFE: ("V2",),
    Rule.SCAN_OF_THIS_TURN: ("V4",),
    Rule.TURN_0_SCAN_ONLY_FOR_TURN_1: ("V4",),
    Rule.SCAN_IN_FORCE: ("V4",),
    Rule.EPOCH_NAMES_LIFE: ("V1",),
    Rule.TIE_AT_TURN_0: ("V8",),
    Rule.NEXT_TURN_ONLY: ("V16", "V19"),
    Rule.RESUMED_WORLD_RAISES: ("V7", "V15"),
    Rule.WRITTEN_FIRST: ("V7",),
    Rule.ODOMETRY_NUMBERED: ("V18",),
    Rule.STOPPED_REFUSES_RAISES: ("V11",),
}
