"""The names of the coverage counters, as tables and outcomes show them."""

from enum import StrEnum

from protocol.fence import Cause


class Situation(StrEnum):
    """A situation that a long campaign must contain."""

    # Processes.
    LEADER_KILLED = "leader killed"
    KILLED_IN_SUCCESSION = "coordinator or new leader killed during a succession"
    TAIL_KILLED = "tail killed"
    TWO_NEIGHBOURS_KILLED = "two neighbours killed at once"
    KILLED_AFTER_SCAN = "killed after_scan"
    KILLED_AFTER_PLAN = "killed after_plan"
    KILLED_MID_DRIVE = "killed mid_drive"
    KILLED_BEFORE_ACK = "killed before_ack"
    KILLED_IN_REVERSAL = "killed while the strand turned round, backed up or dissolved"
    KILLED_BESIDE_RESTARTED = "killed beside a robot that was being restarted"
    KILLED_UNSEEN = "killed while the world was down"
    LAGGED_AT_DEATH = "odometry lagged while another robot died"
    ZOMBIE_SPOKE = "zombie spoke"
    RESTART_JOINED = "restarted robot joined"
    BEGAN_BLIND = "restarted robot had no say over its body for a second"
    FALSE_TOKEN_LOSS = "false token loss"  # noqa: S105 - a liveliness token is no password
    BACK_WHILE_CUT = "token came back while cut from the rest"
    # Views.
    START = "view: start"
    NEIGHBOUR_LOST = "view: neighbour lost"
    BLOCKED = "view: way blocked"
    DEAD_END = "view: dead end"
    NO_WAY = "view: leader knows no way"
    PLEA = "view: plea"
    COORDINATOR_LOST = "view: coordinator lost"
    MISFIT = "view: misfit"
    OUTSIDERS = "view: more outsiders than members"
    WORLD_RESTARTED = "view: world restarted"
    RAISES_CROSSED = "two robots raised the same generation"
    EPOCH_REPLACED = "a raise replaced another of its generation"
    RAISE_IN_VAIN = "a raise was not taken"
    VIEW_ENDED_EARLY = "a view ended before its strand had formed"
    COORDINATOR_KILLED_BOUND = "coordinator killed while members reported"
    COORDINATOR_KILLED_JOINING = "coordinator killed during a turn lease"
    COORDINATOR_KILLED_DRIVING = "coordinator killed while its strand drove"
    COORDINATOR_FROZEN = "coordinator frozen while a view formed"
    COORDINATOR_RESTARTED = "coordinator restarted in its own view"
    ROUTER_LOST_IN_VIEW = "router lost while a view formed"
    WORLD_LOST_IN_VIEW = "world killed while a view formed"
    CUT_WHILE_FORMING = "partition while a view formed"
    # Turns.
    TURN_GIVEN = "turn lease given"
    TURN_TAKEN_BACK = "turn lease taken back"
    RAISED_IN_TURN = "a raise ended a turn lease"
    KILLED_IN_OWN_TURN = "killed in its own turn"
    KILLED_IN_TURN = "killed in the turn of another"
    RESTARTED_IN_TURN = "restarted in its own turn"
    # Formations.
    FORMATION_LOST = "a formation reached a member late or never"
    TURNED_ROUND = "turned round by a view"
    DISSOLVED = "dissolved by a view"
    LET_IN = "let in by a plea"
    LEFT_OUT = "stood aside"
    STRANDED = "stranded"
    SPLIT_HELD = "strand healed without a living robot"
    # Messages and orders.
    STALE_EPOCH_REFUSED = "order of an older epoch refused"
    STALE_TURN_REFUSED = "order of an older turn refused"
    STALE_ORDER_REFUSED = "order on stale odometry refused"
    FORMER_ORDER = "order of a former life came"
    FORMER_ORDER_REFUSED = "order of a former life refused"
    LOST = "message lost"
    LOST_IN_BURST = "message lost in a burst"
    DELAYED = "message delayed"
    REORDERED = "message reordered"
    DUPLICATED = "message duplicated"
    DAMAGED = "message damaged"


OF_CAUSE = {
    Cause.START: Situation.START,
    Cause.NEIGHBOUR_LOST: Situation.NEIGHBOUR_LOST,
    Cause.BLOCKED: Situation.BLOCKED,
    Cause.DEAD_END: Situation.DEAD_END,
    Cause.NO_WAY: Situation.NO_WAY,
    Cause.PLEA: Situation.PLEA,
    Cause.COORDINATOR_LOST: Situation.COORDINATOR_LOST,
    Cause.MISFIT: Situation.MISFIT,
    Cause.OUTSIDERS: Situation.OUTSIDERS,
    Cause.WORLD_RESTARTED: Situation.WORLD_RESTARTED,
}
"""Why a view was proposed; there is no operator in a campaign."""
