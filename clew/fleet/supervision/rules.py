"""How a fleet's processes are supervised, as data: what to do about what happens, by state.

Rule 1: every pair of a state and a happening has exactly one rule in `TABLE`. What it does, and what an event
        means, is said elsewhere (`supervisor.py`, `facts.py`), and does not hang on the state.
Rule 2: a run ends in one direction only: the world is asked, then all others, then what is left is killed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto
from itertools import product


class State(Enum):
    """How far a run is."""

    ROUTERS = auto()
    """Routers are started, one when the one before it listens."""
    PAGE = auto()
    """The routers listen; the viewer is about to say where its page is."""
    RUNNING = auto()
    """World and robots are there."""
    GIVING_UP = auto()
    """A part that the run needs is lost. The world may notice by itself and write its verdict."""
    ASKING_WORLD = auto()
    """The world has been asked to end: it closes its books while the robots are still there."""
    ASKING_ALL = auto()
    """All parts that are left have been asked to end."""
    KILLING = auto()
    """All parts that are left have been killed."""
    OVER = auto()
    """Nothing is left to do."""


class What(Enum):
    """What has happened, as far as the rules tell happenings apart."""

    BEGUN = auto()
    ROUTER_LISTENS = auto()
    """For the first time."""
    ALL_LISTEN = auto()
    PAGE_IS_UP = auto()
    PAGE_SETTLED = auto()
    """The page is up, or never will be, or nobody has asked for one."""
    ROUTER_REFUSED = auto()
    """It ended before it ever listened, and has said why: the user asked for what cannot be."""
    ROUTER_FAILED = auto()
    """It ended before it ever listened, for another reason."""
    ROUTER_ENDED = auto()
    ROUTER_SPENT = auto()
    """A router ended, and routers have been started again as often as they may be."""
    WORLD_KILLED = auto()
    """By a signal, before its verdict, and it may be started again."""
    WORLD_ENDED = auto()
    """By itself, after its verdict, or killed once too often."""
    WORLD_GONE = auto()
    """There is no process of it."""
    HOST_FAILED = auto()
    READER_ENDED = auto()
    """A viewer, or a table that has failed: one ends by itself when the verdict is there."""
    ALL_GONE = auto()
    ASKED = auto()
    """By SIGINT, SIGTERM or SIGHUP, to end the run."""
    FAULT = auto()
    """A process fault that somebody asked for: kill, freeze or thaw."""
    RESTART_DUE = auto()
    THAW_DUE = auto()
    TIME_UP = auto()
    """The deadline of the state has passed."""


class Do(Enum):
    """What to do about it."""

    BEGIN = auto()
    START_ROUTER = auto()
    """The next one, if there is one."""
    START_FLEET = auto()
    SAY_PAGE = auto()
    RESTART_ROUTER = auto()
    RESTART_WORLD = auto()
    START_AGAIN = auto()
    """What was to be away for a while."""
    SAY_READER_ENDED = auto()
    """A viewer or a table."""
    INJECT = auto()
    THAW = auto()
    GIVE_UP = auto()
    END_UNREADY = auto()
    END_REFUSED = auto()
    END_WITH_WORLD = auto()
    END_AS_ASKED = auto()
    END_FAILED = auto()
    ASK_ALL = auto()
    KILL = auto()
    EXIT = auto()
    NOTHING = auto()


@dataclass(frozen=True, slots=True)
class Rule:
    """What to do about one of these happenings in one of these states, and why."""

    whats: tuple[What, ...]
    states: tuple[State, ...]
    do: Do
    to: State | None
    """The state that follows; None: the same."""
    why: str


_UP = (State.ROUTERS, State.PAGE, State.RUNNING)
_LIVE = (*_UP, State.GIVING_UP)

RULES = (
    # How a run begins.
    Rule((What.BEGUN,), (State.ROUTERS,), Do.BEGIN, None, "the viewer starts first: it takes longest"),
    Rule((What.ROUTER_LISTENS,), (State.ROUTERS,), Do.START_ROUTER, None, "the second links to the first"),
    Rule((What.ALL_LISTEN,), (State.ROUTERS,), Do.NOTHING, State.PAGE, "a page shows the first moment"),
    Rule((What.PAGE_IS_UP,), _UP, Do.SAY_PAGE, None, "the user wants to open it"),
    Rule((What.PAGE_SETTLED, What.TIME_UP), (State.PAGE,), Do.START_FLEET, State.RUNNING,
         "world and robots need a router, and no viewer"),
    # What is lost, and comes back.
    Rule((What.ROUTER_ENDED,), _UP, Do.RESTART_ROUTER, None, "a run survives the loss of a router"),
    Rule((What.WORLD_KILLED,), (State.RUNNING,), Do.RESTART_WORLD, None, "it goes on from its timeline"),
    Rule((What.RESTART_DUE,), _UP, Do.START_AGAIN, None, "a process fault may name a time away"),
    Rule((What.READER_ENDED,), _UP, Do.SAY_READER_ENDED, None, "it only reads: the run goes on"),
    # Process faults.
    Rule((What.FAULT,), _LIVE, Do.INJECT, None, "somebody asked for it"),
    Rule((What.THAW_DUE,), _LIVE, Do.THAW, None, "a process fault may name a time frozen"),
    # Why a run ends.
    Rule((What.WORLD_ENDED,), (State.RUNNING, State.GIVING_UP), Do.END_WITH_WORLD, State.ASKING_WORLD,
         "its verdict is the run's"),
    Rule((What.ASKED,), _LIVE, Do.END_AS_ASKED, State.ASKING_WORLD, "the user decides"),
    Rule((What.ROUTER_REFUSED,), (State.ROUTERS,), Do.END_REFUSED, State.ASKING_WORLD,
         "the user has to ask for something else"),
    Rule((What.ROUTER_FAILED, What.TIME_UP), (State.ROUTERS,), Do.END_UNREADY, State.ASKING_WORLD,
         "what fails at once fails again"),
    Rule((What.ROUTER_SPENT,), _UP, Do.GIVE_UP, State.GIVING_UP, "a router that cannot live has an end"),
    Rule((What.HOST_FAILED,), (State.RUNNING,), Do.GIVE_UP, State.GIVING_UP, "there are no robots left"),
    # How it ends.
    Rule((What.WORLD_GONE, What.TIME_UP), (State.GIVING_UP,), Do.END_FAILED, State.ASKING_WORLD,
         "a world that has not noticed by then never will"),
    Rule((What.WORLD_GONE, What.TIME_UP), (State.ASKING_WORLD,), Do.ASK_ALL, State.ASKING_ALL,
         "robots have to be there while the world closes its books"),
    Rule((What.TIME_UP,), (State.ASKING_ALL,), Do.KILL, State.KILLING, "nothing stays behind"),
    Rule((What.ALL_GONE,), (State.ASKING_ALL,), Do.EXIT, State.OVER, "nothing is left to wait for"),
    Rule((What.ALL_GONE, What.TIME_UP), (State.KILLING,), Do.EXIT, State.OVER,
         "the kernel ends them as soon as it can"),
)  # fmt: skip

IGNORED: Mapping[What, str] = {
    What.BEGUN: "a run begins once",
    What.ROUTER_LISTENS: "the run ends already",
    What.ALL_LISTEN: "the others have been started",
    What.PAGE_IS_UP: "nobody can open it any more",
    What.PAGE_SETTLED: "nobody waits for it",
    What.ROUTER_ENDED: "nothing is started any more",
    What.WORLD_KILLED: "nothing is started any more",
    What.RESTART_DUE: "nothing is started any more",
    What.READER_ENDED: "the run does not go on",
    What.FAULT: "nothing disturbs the end",
    What.THAW_DUE: "the end has thawed it",
    What.WORLD_ENDED: "the end has another cause",
    What.ASKED: "asking twice changes nothing",
    What.ROUTER_REFUSED: "the end has another cause",
    What.ROUTER_FAILED: "the end has another cause",
    What.ROUTER_SPENT: "the end has another cause",
    What.HOST_FAILED: "the end has another cause",
    What.WORLD_GONE: "nobody waits for it",
    What.ALL_GONE: "nobody waits for it",
    What.TIME_UP: "the state has no deadline",
}
"""Why nothing is done about a happening in those states for which no rule names it."""

TABLE: Mapping[tuple[State, What], Rule] = {
    (state, what): Rule((what,), (state,), Do.NOTHING, None, IGNORED[what])
    for state, what in product(State, What)
} | {pair: rule for rule in RULES for pair in product(rule.states, rule.whats)}
